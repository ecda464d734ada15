"""A scene to its kernel: plan, kinematics, dynamics, layout, start."""
