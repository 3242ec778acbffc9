"""What one section alone cannot show: order and names of phases, layers of the current, correlations, requirements.

Each check takes the sections that it compares and lists what is wrong, by key path from the top of the mission.
"""
