"""Loading ends when the process is told to end, whatever it is at."""

import subprocess
import sys
import threading

import pytest

from runtime.errors import ModelError
from runtime.loops import loading
from runtime.loops.loading import LoadingEndedError, loaded


def fails() -> None:
    raise ModelError("yolo.onnx: no such model file")


def test_what_was_loaded_or_what_went_wrong():
    assert loaded(lambda: 7, 0, lambda: False) == 7
    with pytest.raises(ModelError, match=r"yolo\.onnx: no such model file"):
        loaded(fails, 0, lambda: False)


def test_a_process_that_is_to_end_does_not_wait_for_its_models():
    held, told = threading.Event(), threading.Event()
    threading.Timer(0.3, told.set).start()
    with pytest.raises(LoadingEndedError) as caught:
        loaded(held.wait, 0, told.is_set)
    assert caught.value.status == 0
    held.set()


def test_models_that_never_come_are_given_up(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(loading, "LOAD_S", 0.3)
    held = threading.Event()
    with pytest.raises(LoadingEndedError, match=r"models: not loaded within 0\.3 s") as caught:
        loaded(held.wait, 0, lambda: False)
    assert caught.value.status == 2
    held.set()


def test_the_process_is_left_while_a_thread_computes():
    code = (
        "import threading, hashlib\n"
        "from runtime.loops.loading import leave\n"
        "work = lambda: hashlib.pbkdf2_hmac('sha256', b'a', b'b', 10**9)\n"
        "threading.Thread(target=work).start()\n"
        "print('said')\n"
        "leave(3)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (3, "said\n")
