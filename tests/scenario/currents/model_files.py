"""Small files as ocean models write them, by the models' formulas."""

import numpy as np
import pytest

netcdf = pytest.importorskip("netCDF4")
HOURS = np.array([-1.0, 0.0, 1.0, 2.0, 3.0])
"""Of 12:00 on 1 May 2026."""


def variable(file, name, dims, values, **attributes):
    values = np.asarray(values)
    for dim, size in zip(dims, values.shape, strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, size)
    fill = {"fill_value": 1e37} if values.dtype.kind == "f" and np.isnan(values).any() else {}
    made = file.createVariable(name, values.dtype.kind + "8" if values.dtype.kind == "f" else "i4", dims, **fill)
    made.setncatts(attributes)
    made[:] = np.ma.masked_invalid(values) if fill else values
    return made


def times(file, name, hours=HOURS):
    variable(file, name, (name,), hours, units="hours since 2026-05-01 12:00:00")


def bent_grid(rows=9, columns=11, spacing=900.0, turn=0.35):
    """Longitudes, latitudes and angle of a grid that is turned and whose rows bend."""
    a, b = np.meshgrid(np.arange(columns) - columns // 2, np.arange(rows) - rows // 2)
    x, y = spacing * (a + 0.02 * b * b), spacing * (b + 0.015 * a * a)
    x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    longitude = -124.0 + np.degrees(x / (6_367_000.0 * np.cos(np.radians(45.0))))
    angle = np.arctan2(np.gradient(y, axis=1), np.gradient(x, axis=1))
    return longitude, 45.0 + np.degrees(y / 6_367_000.0), angle


def roms(path, transform, **changes):
    """A file of ROMS with five s-levels, a moving surface, masks and staggered velocities at random."""
    rng = np.random.default_rng(3)
    longitude, latitude, angle = bent_grid()
    rows, columns = longitude.shape
    s = (np.arange(5) - 4.5) / 5.0
    theta_s, theta_b = 5.0, 0.4
    stretching = (1 - theta_b) * np.sinh(theta_s * s) / np.sinh(theta_s) + theta_b * (
        np.tanh(theta_s * (s + 0.5)) / (2 * np.tanh(0.5 * theta_s)) - 0.5
    )
    made = {
        "longitude": longitude,
        "latitude": latitude,
        "angle": angle,
        "s": s,
        "stretching": stretching,
        "critical": 4.0,
        "bottom": rng.uniform(20.0, 60.0, (rows, columns)),
        "surface": rng.uniform(-1.0, 1.0, (HOURS.size, rows, columns)),
        "u": rng.normal(0.0, 0.4, (HOURS.size, 5, rows, columns - 1)),
        "v": rng.normal(0.0, 0.4, (HOURS.size, 5, rows - 1, columns)),
        "mask": np.ones((rows, columns)),
    } | changes
    with netcdf.Dataset(path, "w") as file:
        times(file, "ocean_time")
        rho = ("eta_rho", "xi_rho")
        variable(file, "lon_rho", rho, made["longitude"], units="degree_east")
        variable(file, "lat_rho", rho, made["latitude"], units="degree_north")
        variable(file, "angle", rho, made["angle"], units=changes.get("angle_units", "radians"))
        variable(file, "mask_rho", rho, made["mask"])
        variable(file, "h", rho, made["bottom"], units="meter")
        variable(file, "zeta", ("ocean_time", *rho), made["surface"], units="meter")
        variable(file, "s_rho", ("s_rho",), made["s"])
        variable(file, "Cs_r", ("s_rho",), made["stretching"])
        variable(file, "hc", (), np.float64(made["critical"]))
        variable(file, "Vtransform", (), np.int32(transform))
        unit = changes.get("units", "meter second-1")
        variable(file, "u", ("ocean_time", "s_rho", "eta_u", "xi_u"), made["u"], units=unit)
        variable(file, "v", ("ocean_time", "s_rho", "eta_v", "xi_v"), made["v"], units=unit)
    return made


def mesh_nodes(count=7, spacing=800.0):
    rng = np.random.default_rng(5)
    x, y = (axis.ravel() for axis in np.meshgrid(*2 * (spacing * (np.arange(count) - count // 2),)))
    return x + rng.uniform(-150.0, 150.0, x.size), y + rng.uniform(-150.0, 150.0, x.size)


def mesh_faces(count=7):
    """Alternately a four-sided face and two triangles, nodes counted from 1, in the file's way with a fill value."""
    faces = []
    for j in range(count - 1):
        for i in range(count - 1):
            a = j * count + i + 1
            square = (a, a + 1, a + count + 1, a + count)
            faces += (
                [square]
                if (i + j) % 2
                else [(square[0], square[1], square[2], -1), (square[0], square[2], square[3], -1)]
            )
    return np.array(faces)


def ugrid(path, at, layers=None):
    """A file with a UGRID mesh in metres: random velocities at nodes or faces, sigma layers, depths or one level."""
    rng = np.random.default_rng(6)
    (x, y), faces = mesh_nodes(), mesh_faces()
    columns = x.size if at == "node" else len(faces)
    made = {"x": x, "y": y, "faces": faces, "bottom": rng.uniform(15.0, 30.0, x.size)}
    with netcdf.Dataset(path, "w") as file:
        times(file, "time")
        mesh = variable(file, "mesh", (), np.int32(1), cf_role="mesh_topology", topology_dimension=2)
        mesh.setncatts({"node_coordinates": "node_x node_y", "face_node_connectivity": "faces"})
        variable(file, "node_x", ("node",), x, units="m")
        variable(file, "node_y", ("node",), y, units="m")
        variable(file, "faces", ("face", "corner"), faces, start_index=1)
        variable(file, "depth", ("node",), made["bottom"], standard_name="sea_floor_depth_below_geoid", units="m")
        shape, dims = [HOURS.size, columns], ["time", at]
        if layers is not None:
            sigma = (
                {"standard_name": "ocean_sigma_coordinate"}
                if layers.max() <= 0.0
                else {"positive": "down", "units": "m"}
            )
            variable(file, "layer", ("layer",), layers, **sigma)
            shape, dims = [HOURS.size, layers.size, columns], ["time", "layer", at]
        for name, way in (("ucx", "eastward"), ("ucy", "northward")):
            made[name] = rng.normal(0.0, 0.3, shape)
            variable(file, name, dims, made[name], standard_name=f"{way}_sea_water_velocity", units="m s-1")
    return made


def split(faces):
    """Triangles of the faces, counted from 0: a four-sided one is cut from its first to its third corner."""
    return [(f[0] - 1, f[k] - 1, f[k + 1] - 1) for f in faces for k in (1, 2) if f[k + 1] > 0]


def fvcom(path, gradients):
    """A file of FVCOM in degrees; with its own gradients, which here are half of those that fit best."""
    rng = np.random.default_rng(4)
    x, y = mesh_nodes()
    faces = np.array(split(mesh_faces()))
    longitude, latitude = -124.0 + np.degrees(x / (6.378e6 * np.cos(np.radians(45.0)))), 45.0 + np.degrees(y / 6.367e6)
    sides = [frozenset(pair) for pair in ((1, 2), (2, 0), (0, 1))]
    beside = np.zeros((3, len(faces)), dtype=int)
    for cell, face in enumerate(faces):
        for side, ends in enumerate(sides):
            wanted = {int(face[k]) for k in ends}
            for other, theirs in enumerate(faces):
                if other != cell and wanted <= set(map(int, theirs)):
                    beside[side, cell] = other + 1
    made = {"faces": faces, "beside": beside, "sigma": -np.array([0.05, 0.3, 0.7, 0.95])}
    made["bottom"], made["surface"] = rng.uniform(10.0, 25.0, x.size), rng.uniform(-1.0, 1.0, (HOURS.size, x.size))
    made["u"], made["v"] = rng.normal(0.0, 0.3, (2, HOURS.size, 4, len(faces)))
    made["a"] = rng.normal(0.0, 2e-4, (2, 4, len(faces)))
    with netcdf.Dataset(path, "w") as file:
        times(file, "time")
        variable(file, "lon", ("node",), longitude, units="degrees_east")
        variable(file, "lat", ("node",), latitude, units="degrees_north")
        variable(file, "lonc", ("nele",), longitude[faces].mean(axis=1), units="degrees_east")
        variable(file, "latc", ("nele",), latitude[faces].mean(axis=1), units="degrees_north")
        variable(file, "nv", ("three", "nele"), faces.T + 1)
        variable(file, "nbe", ("three", "nele"), beside)
        variable(file, "h", ("node",), made["bottom"])
        variable(file, "zeta", ("time", "node"), made["surface"])
        variable(file, "siglay", ("siglay", "node"), np.repeat(made["sigma"][:, None], x.size, axis=1))
        for name in ("u", "v"):
            variable(file, name, ("time", "siglay", "nele"), made[name], units="meters s-1")
        if gradients:
            for name, values in zip(("a1u", "a2u"), made["a"], strict=True):
                variable(file, name, ("four", "nele"), values)
    return made
