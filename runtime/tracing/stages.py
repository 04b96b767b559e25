"""What is timed: the stages of the loop, each of one thread."""

from enum import StrEnum


class Stage(StrEnum):
    """A part of a tick of the control loop, of a frame, or of what is done beside them."""

    LATE = "late"  # how long after its time a tick of the control loop begins
    TICK = "tick"  # from the odometry that is read to the command on the wire
    FRAME = "frame"  # from a frame's arrival to the map that has it
    PREPARE = "prepare"  # flying pixels, the camera's mount
    SURVEY = "survey"  # navigation map, frontiers, terrain and distances
    PLACE = "place"  # what the detector saw onto the map
    DECIDE = "decide"  # adopt a decision, tell the experts what the next is about
    ACT = "act"  # what to do now
    REPORT = "report"  # the plan handed over, the step written
    GARBAGE = "garbage"  # Python's own
    DETECT = "detect"  # a look of the detectors, in their thread
    SCORE = "score"  # a prompt to the language model that scores words, in its thread
    SEEN = "seen"  # from a frame's arrival to what was seen in it on the map
