"""`python -m runtime.bench.sleeper HZ`: a thread that only sleeps, in a process of its own: how
late it wakes is the machine's doing. Prints one line of JSON when its input ends."""

import json
import sys
import threading
import time

from runtime.tracing.histogram import Histogram


def main() -> None:
    """Until the input is closed; `clear` on a line begins anew."""
    period_s, ending, clear = 1.0 / float(sys.argv[1]), threading.Event(), threading.Event()

    def listen() -> None:
        for _ in sys.stdin:
            clear.set()
        ending.set()

    threading.Thread(target=listen, daemon=True).start()
    late, due_s = Histogram(), time.monotonic()
    while not ending.is_set():
        if clear.is_set():
            late = Histogram()
            clear.clear()
        now_s = time.monotonic()
        late.add(max(0.0, now_s - due_s))
        due_s = max(due_s + period_s, now_s - period_s)
        time.sleep(max(0.0, due_s - time.monotonic()))
    print(json.dumps(late.told()))


if __name__ == "__main__":
    main()
