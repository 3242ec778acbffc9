"""Pure functions of SI floats and arrays, with equation, units and source: one physical effect, one function.

Drag and descent: `water`, `drag`, `vehicle_drag`, `added_mass`, `buoyancy`, `anchor`, `anchor_remedies`, `mooring`.
Propulsion: `propeller`, `propulsion`, `cruise`, `energy`. Hover and tank: `vehicle_dynamics`, `tunnel_thruster`,
`thruster`, `tank`, `oscillation`, `measured_drag`.
"""
