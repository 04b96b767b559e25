"""The robot's runtime."""

import os

# Before numpy is imported. Its products here are small: threads for them gain nothing and spin on
# cores that the detector and the language model need (with both busy, 8 ms in 60 of a detection).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Before OpenCV is: an image that claims more pixels in its header than any camera has is none.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", "64000000")
