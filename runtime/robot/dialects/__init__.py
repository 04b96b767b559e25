"""How ROS 2 is spoken over Zenoh: one module a dialect, and what both have in common."""
