"""Mode and arming: who has the vehicle, and how it is asked for. No thread, no clock, no socket.

Nothing is asked for without leave (`rfnav run --arm`), and with it once a search, but of nobody who
drives it, armed, in another mode: what a person or a failsafe changes after that stays as it is.
What was armed for a search is disarmed after it. Whoever takes the vehicle out of GUIDED has the
sticks until it is back in it.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from pymavlink.dialects.v20 import common as mavlink

from runtime.robot.mavlink.vehicle import GUIDED, GUIDED_NAME, PX4_HOLD, Autopilot, Vehicle

TRIES: Final = 3
TRY_S: Final = 1.0  # between two of them
STAND_S: Final = 1.0  # to come to rest, before it is disarmed
ANSWER_S: Final = 4.0  # for a request to show in a heartbeat, with all its tries
STREAM_S: Final = 1.5  # PX4 enters OFFBOARD after more than a second of set-points
RESULTS: Final = {
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED: "rejected for now",
    mavlink.MAV_RESULT_DENIED: "denied",
    mavlink.MAV_RESULT_UNSUPPORTED: "unsupported",
    mavlink.MAV_RESULT_FAILED: "failed",
    6: "cancelled",  # MAV_RESULT_CANCELLED
}
ARM: Final = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
MODE: Final = mavlink.MAV_CMD_DO_SET_MODE
ARMING: Final = "arming"


class VehicleCommand(NamedTuple):
    """A COMMAND_LONG: its number and parameters, and how often it was sent before."""

    number: int
    parameters: tuple[float, ...]
    sent: int


@dataclass
class _Request:
    """Something that is asked for, and what becomes of that."""

    number: int
    parameters: tuple[float, ...]
    what: str
    sent: int = 0
    next_s: float = 0.0
    accepted: bool = False


class Takeover:
    """`may_arm`: whether mode and arming may be asked for."""

    def __init__(self, may_arm: bool) -> None:
        self._may = may_arm
        self._searching_s: float | None = None  # since when
        self._request: _Request | None = None
        self._refused = ""
        self._had_guided = False
        self._asked_hold = False  # and it has not come yet
        self._was_armed = False  # in this search
        self._asked_mode = False
        self._asked_arm = False
        self._ours = False  # it was armed for us
        self._disarm_s: float | None = None  # when it is to be disarmed
        self._disarming_s = -math.inf  # until when that may show
        self.hand = ""

    @property
    def idle(self) -> bool:
        """Whether nothing is to be asked for, and no answer is waited for."""
        return self._request is None and self._disarm_s is None

    def begin(self, now_s: float) -> None:
        """A search wants to drive."""
        self._searching_s, self._request, self._refused = now_s, None, ""
        self._disarm_s = None
        self._was_armed = self._asked_mode = self._asked_arm = False

    def end(self, vehicle: Vehicle, now_s: float, by_hand: bool = False) -> None:
        """The search is over. PX4 takes OFFBOARD without a stream for a failure, so that it is put
        on hold; ArduPilot stands in GUIDED. What was armed for us is disarmed when it stands. What
        somebody else drives, `by_hand`, is left as it is."""
        self._searching_s, self._request, self._refused = None, None, ""
        if by_hand:
            return
        if self._ours and not self.hand:
            self._disarm_s = now_s + STAND_S
        if vehicle.autopilot is Autopilot.PX4 and vehicle.guided():
            self._had_guided, self._asked_hold = False, True
            self._request = _mode_request(PX4_HOLD, "HOLD")

    def heard(self, vehicle: Vehicle) -> None:
        """After each heartbeat."""
        request = self._request
        leaving = request is not None and request.what == "HOLD"
        if vehicle.guided():
            self._had_guided, self.hand = not leaving, ""
        elif self._asked_hold and vehicle.mode == PX4_HOLD:
            self._had_guided = self._asked_hold = False  # it was us, however late it comes
        elif self._had_guided:
            self.hand = f"mode {vehicle.mode_name()}"
            self._request = self._disarm_s = None  # whose it is now has his own mind
        if request is not None and _granted(request, vehicle):
            self._ours = self._ours or request.what == ARMING
            self._request = None
        if not vehicle.armed:
            self._ours, self._disarm_s, self._disarming_s = False, None, -math.inf
        elif self._searching_s is not None and vehicle.heartbeat_s > self._disarming_s:
            self._was_armed = True

    def acked(self, number: int, result: int, said: str) -> None:
        """A COMMAND_ACK; `said`: what the vehicle warned of lately, which is mostly why."""
        request = self._request
        if request is None or request.number != number:
            return
        if result == mavlink.MAV_RESULT_ACCEPTED:
            request.accepted = True  # granted when the heartbeat says so
        elif result != mavlink.MAV_RESULT_IN_PROGRESS:
            why = RESULTS.get(result, f"result {result}")
            self._refuse(f"{request.what}: {why}" + (f" ({said})" if said else ""))

    def due(self, vehicle: Vehicle, now_s: float) -> VehicleCommand | None:
        """What is to be sent now."""
        if self._request is None and self._may and self._searching_s is not None:
            self._request = self._next(vehicle, now_s)
        elif self._request is None and self._disarm_s is not None and now_s >= self._disarm_s:
            self._disarm_s, self._disarming_s = None, now_s + ANSWER_S
            self._request = _Request(ARM, (0.0, 0.0), "disarming")
        request = self._request
        if request is None or now_s < request.next_s:
            return None
        if request.sent >= TRIES:
            told = "was accepted, but does not come" if request.accepted else "is not answered"
            self._refuse(f"{request.what}: {told}")
            return None
        sent = request.sent
        request.sent, request.next_s = sent + 1, now_s + TRY_S
        if request.accepted:
            return None
        return VehicleCommand(request.number, request.parameters, sent)

    def lacks(self, vehicle: Vehicle) -> str:
        """What of mode and arming is missing to be driven; "" when nothing is."""
        assert vehicle.autopilot is not None
        guided = GUIDED_NAME[vehicle.autopilot]
        if self.hand:
            return ""  # which is told as such
        if self._refused:
            return f"{self._refused}; see to it, then give the goal again"
        if not vehicle.guided():
            what = f"mode {vehicle.mode_name()}"
            if vehicle.driven():
                return f"{what}, and armed: somebody drives it; switch it to {guided}"
            if self._may and (self._request is not None or not self._asked_mode):
                return f"{what}: {guided} is asked for"
            return f"{what}: switch it to {guided}{'' if self._may else ', or run with --arm'}"
        if not vehicle.armed:
            if self._was_armed:
                return "was disarmed: arm it, or give the goal again"
            asked = "that is asked for" if self._may else "arm it, or run with --arm"
            return f"not armed: {asked}"
        return ""

    def _next(self, vehicle: Vehicle, now_s: float) -> _Request | None:
        if self.hand or self._refused or vehicle.autopilot is None or self._searching_s is None:
            return None
        if not vehicle.guided():
            streamed = now_s - self._searching_s >= STREAM_S
            if self._asked_mode or (vehicle.autopilot is Autopilot.PX4 and not streamed):
                return None
            self._asked_mode = True
            if vehicle.driven():
                return None  # nor later in this search: who stops it wants it to stand
            return _mode_request(GUIDED[vehicle.autopilot], GUIDED_NAME[vehicle.autopilot])
        if not vehicle.armed and not self._was_armed and not self._asked_arm:
            self._asked_arm = True
            return _Request(ARM, (1.0, 0.0), ARMING)  # never by force
        return None

    def _refuse(self, why: str) -> None:
        self._request, self._refused = None, why


def _mode_request(mode: int, what: str) -> _Request:
    """`mode`: custom_mode. PX4's main and sub mode have a parameter each."""
    main, sub = (mode >> 16 & 0xFF, mode >> 24 & 0xFF) if mode >> 16 else (mode, 0)
    flag = float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
    return _Request(MODE, (flag, float(main), float(sub)), what)


def _granted(request: _Request, vehicle: Vehicle) -> bool:
    if request.what == "HOLD":
        return not vehicle.guided()
    if request.number == ARM:
        return vehicle.armed == (request.what == ARMING)
    return vehicle.guided()
