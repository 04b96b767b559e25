"""Models: where they come from, and how they are asked."""

import os

# ONNX Runtime's builds for Linux tell its maker of every model that is opened, and keep a number of
# this device, unless this is set before it is loaded. A robot sends nothing that nobody allowed.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
