"""The core's inner loops, compiled: what NumPy and OpenCV would do in many passes over arrays, or
not at all. Each takes arrays and changes or returns arrays; none keeps anything."""
