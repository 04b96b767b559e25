"""A base on MAVLink: ArduPilot's Rover in GUIDED, PX4's in OFFBOARD."""
