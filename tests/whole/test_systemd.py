"""RF-NAV as a service under a real systemd, in a Debian that is booted for it: installed from
wheels, asked for things by a robot on this computer, killed, frozen, starved, upgraded, removed.
The tests are one life, in order."""

import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from authority import certified
from labelled_robot import LabelledRobot
from nspawn import Machine, why_not
from places import ROOT

from hil_sim.driving.link import free_port
from runtime.core.types import Twist
from runtime.robot.session import BusConfig

pytestmark = [pytest.mark.slow, pytest.mark.systemd]

UNITS = ("rf-nav.service", "rf-nav-guard.service")
EXPOSED = 3.0  # at most, of 10
STILL = Twist(0.0, 0.0)
CONFIG = "/etc/rf-nav/robot.toml"
MINUTES = os.environ.get("RFNAV_SOAK_MINUTES", "3")
BUS = """
[bus]
mode = "client"
connect = ["{endpoint}"]
"""
OURS = f"""{BUS}
[research]
detector_source = "topic"
detector_labels = ["chair"]
"""
CLOUD = """
[cloud]
enabled = true
base_url = "http://127.0.0.1:1/v1"
model = "m"
price_in_usd = 0.0
price_out_usd = 0.0
credential = "rf-nav.cloud-key"
"""
CERTIFICATES = """
[bus.tls]
ca = "$CREDENTIALS_DIRECTORY/rf-nav.ca.pem"
certificate = "$CREDENTIALS_DIRECTORY/rf-nav.robot.pem"
private_key = "$CREDENTIALS_DIRECTORY/rf-nav.robot-key.pem"
"""
RESTS = "systemctl show -p SubState --value rf-nav | grep -qx running"
STARVED_BYTES = 1 << 20
ROLLBACK = "/opt/rf-nav/current/share/rf-nav/install.sh"
EVERYTHING = (
    "find / -xdev \\( -path /proc -o -path /run -o -path /tmp -o -path /var/log -o -path /bundle"
    " -o -path /newer \\) -prune -o -print | sort"
)


@dataclass
class Life:
    """The machine and what lies beside it. `before`: every file, before anything was installed."""

    machine: Machine
    before: list[str]
    robot: LabelledRobot
    port: int

    def property(self, name: str, unit: str = "rf-nav") -> str:
        return self.machine.told("systemctl", "show", "-p", name, "--value", unit)

    def configure(self, more: str = "", endpoint: str = "") -> None:
        text = OURS.format(endpoint=endpoint or f"tcp/127.0.0.1:{self.port}") + more
        self.machine.shell(f"cat >{CONFIG} <<'END'\n{text}\nEND")

    def ready(self) -> None:
        self.machine.until(RESTS)

    def drives(self) -> None:
        """A search is under way, and the base moves."""
        assert self.robot.ask("goal", {"goal": "chair"})["accepted"]
        self.robot.until(lambda: self.robot.commands and self.robot.commands[-1] != STILL)

    def back(self, restarts: int) -> None:
        """It was started anew, for the so manieth time, and takes goals."""
        self.machine.until(f'[ "$(systemctl show -p NRestarts --value rf-nav)" = {restarts} ]')
        self.ready()
        assert self.robot.ask("status")["runtime"]["state"] != "fault"


@contextmanager
def starved(life: Life) -> Iterator[None]:
    """Less memory than what runs has: by MemoryMax, or where this computer has the old control
    groups, which a machine in it has no part in, by one of those."""
    group = Path("/sys/fs/cgroup/memory") / f"rf-nav-{os.getpid()}"
    limit = "systemctl set-property --runtime rf-nav MemoryMax={}"
    if not group.parent.is_dir():
        life.machine.shell(limit.format(STARVED_BYTES))
        yield
        life.machine.shell(limit.format("1500M"))
        return
    pid = life.machine.here(int(life.property("MainPID")))
    group.mkdir()
    (group / "memory.limit_in_bytes").write_text(str(STARVED_BYTES))
    (group / "cgroup.procs").write_text(str(pid))
    yield
    group.rmdir()


def renamed(wheel: Path, version: str, folder: Path) -> Path:
    """The same wheel, as if it was of another version."""
    was = f"rf_nav-{wheel.name.split('-')[1]}."
    made = folder / re.sub(r"^rf_nav-[^-]+", f"rf_nav-{version}", wheel.name)
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(made, "w", zipfile.ZIP_STORED) as new:
        for info in old.infolist():
            content, name = old.read(info), info.filename
            if name.endswith((".dist-info/METADATA", ".dist-info/RECORD")):
                text = re.sub(r"^Version: .*$", f"Version: {version}", content.decode(), flags=re.M)
                content = text.replace(was, f"rf_nav-{version}.").encode()
            info.filename = name.replace(was, f"rf_nav-{version}.")
            new.writestr(info, content)
    return made


@pytest.fixture(scope="module")
def life(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Life]:
    if why := why_not():
        pytest.skip(f"THE SERVICE IS NOT TESTED: {why}")
    work, port = tmp_path_factory.mktemp("systemd"), free_port()
    bundle, newer = work / "bundle", work / "newer"
    subprocess.run([ROOT / "scripts" / "bundle", bundle], check=True, umask=0o077)
    newer.mkdir()
    [wheel] = (bundle / "wheels").glob("rf_nav-*.whl")
    renamed(wheel, "99.0.0", newer)
    robot = LabelledRobot(BusConfig(listen=(f"tcp/127.0.0.1:{port}",)))
    robot.start()
    with ExitStack() as stack:
        stack.callback(robot.close)
        try:
            machine = stack.enter_context(Machine(work, {"/bundle": bundle, "/newer": newer}))
        except OSError as error:
            pytest.skip(f"THE SERVICE IS NOT TESTED: {error}")
        yield Life(machine, machine.shell(EVERYTHING).splitlines(), robot, port)


def test_it_is_installed_from_wheels_and_a_second_time_changes_nothing(life: Life) -> None:
    machine = life.machine
    done = machine.run("/bundle/install.sh")
    assert done.returncode == 0, done.stderr
    assert "is installed; when /etc/rf-nav/robot.toml is your robot's" in done.stderr
    installed = machine.shell(EVERYTHING)
    assert machine.shell("find /bundle /opt/rf-nav -not -type l -not -perm -004") == ""
    life.configure()
    again = machine.run("/bundle/install.sh")
    assert again.returncode == 0, again.stderr
    assert machine.shell(EVERYTHING) == installed
    assert f"tcp/127.0.0.1:{life.port}" in machine.shell(f"cat {CONFIG}")  # which was not touched
    assert machine.shell("stat -c '%a %U:%G' /var/lib/rf-nav") == "700 rf-nav:rf-nav"


def test_what_is_in_the_way_is_told_a_line_each_and_nothing_is_changed(life: Life) -> None:
    before = life.machine.shell(EVERYTHING)
    done = life.machine.run("/bundle/install.sh", "--wheels", "/nowhere")
    assert done.returncode == 2
    assert re.fullmatch(r"install: /nowhere/rf_nav-\*\.whl: no wheel; .*\n", done.stderr)
    wheel = "/newer/" + newest(life.machine)
    done = life.machine.run("/bundle/install.sh", "--wheel", wheel, "--wheels", "/newer")
    assert done.returncode == 2
    assert re.fullmatch(
        r"install: /newer: is not for cp311 on \w+: run scripts/bundle .*\n", done.stderr
    )
    assert life.machine.shell(EVERYTHING) == before


@pytest.mark.parametrize("unit", UNITS)
def test_little_is_open_to_it(life: Life, unit: str) -> None:
    told = life.machine.told("systemd-analyze", "security", "--no-pager", unit)
    found = re.search(r"Overall exposure level for \S+: ([\d.]+)", told)
    assert found is not None, told
    assert float(found[1]) <= EXPOSED


def test_its_units_say_nothing_that_systemd_does_not_know(life: Life) -> None:
    done = life.machine.run("systemd-analyze", "verify", *UNITS, "rf-nav-again.service")
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_it_starts_takes_a_goal_and_finds_it(life: Life) -> None:
    life.machine.shell("systemctl start rf-nav")  # and waits for READY=1
    life.machine.until("systemctl show -p StatusText --value rf-nav | grep -qx ready")
    assert life.property("ActiveState", "rf-nav-guard") == "active"
    life.drives()
    life.robot.until(lambda: life.robot.state().get("state") == "found")
    assert life.machine.shell("ls /var/lib/rf-nav/searches")
    owners = "find /var/lib/rf-nav -not -user rf-nav -o -type f -perm /077"
    assert life.machine.shell(owners) == ""


def test_its_journal_has_fields_and_it_says_how_it_stands_and_why(life: Life) -> None:
    life.drives()
    life.robot.ask("cancel")
    told = life.machine.shell("journalctl -u rf-nav RFNAV_EVENT=result -n 1 -o json --no-pager")
    entry = json.loads(told)
    assert (entry["RFNAV_RESULT"], entry["PRIORITY"]) == ("cancelled", "5")
    assert entry["_SYSTEMD_UNIT"] == "rf-nav.service"
    assert {"ready", "searching"} & set(life.machine.shell("journalctl -F RFNAV_STATE").split())
    assert "-> ready" in life.machine.told("journalctl", "-t", "rfnav", "-o", "cat", "--no-pager")
    ask = "/opt/rf-nav/current/bin/rfnav {} --config " + CONFIG
    status = json.loads(life.machine.told("sh", "-c", ask.format("status --json")))
    assert status["runtime"]["state"] == "ready"
    assert life.machine.shell(ask.format("why")).startswith("Now: no search.\n\nDecision ")


def test_killed_it_is_back_and_meanwhile_the_guard_has_stopped_the_base(life: Life) -> None:
    life.drives()
    life.machine.shell("systemctl kill --kill-whom=main -s KILL rf-nav")
    life.robot.until(lambda: life.robot.commands[-1] == STILL)
    told = life.machine.told("journalctl", "-u", "rf-nav-guard", "-o", "cat", "--no-pager")
    assert re.search(
        "rfnav guard: the control loop (ended|gave no sign.*): zero is commanded", told
    )
    life.back(1)


def test_frozen_it_is_killed_by_systemds_watchdog_and_back(life: Life) -> None:
    life.drives()
    life.machine.shell("systemctl kill --kill-whom=main -s STOP rf-nav")
    life.robot.until(lambda: life.robot.commands[-1] == STILL)
    life.back(2)
    told = life.machine.told("journalctl", "-u", "rf-nav", "-o", "cat", "--no-pager")
    assert "Failed with result 'watchdog'" in told


def test_out_of_memory_it_is_killed_and_back(life: Life) -> None:
    life.drives()
    with starved(life):
        life.robot.until(lambda: life.robot.commands[-1] == STILL)
        life.machine.until('[ "$(systemctl show -p NRestarts --value rf-nav)" = 3 ]')
    life.ready()
    told = life.machine.told("journalctl", "-u", "rf-nav", "-o", "cat", "--no-pager")
    assert re.search(r"code=killed, status=9/KILL|oom-kill", told)


def test_on_a_full_disk_it_goes_on_and_says_what_is_lost(life: Life) -> None:
    machine, searches = life.machine, "/var/lib/rf-nav/searches"
    machine.shell(f"mount -t tmpfs -o size=64k,mode=700,uid=$(id -u rf-nav) full {searches}")
    try:
        machine.shell(f"head -c 60000 /dev/zero >{searches}/much; systemctl restart rf-nav")
        life.drives()
        life.robot.until(lambda: life.robot.ask("status")["journal_lost"])
        life.drives()  # and takes another goal
    finally:
        machine.shell(f"umount -l {searches}; systemctl restart rf-nav")


def test_keys_are_credentials_of_the_runtime_and_of_its_guard(life: Life, tmp_path: Path) -> None:
    machine, port = life.machine, free_port()
    own = certified(tmp_path, "robot", "127.0.0.1")
    secrets = {"cloud-key": "sk-test\n"}
    for name, path in zip(
        ("ca.pem", "robot.pem", "robot-key.pem"), own.named.values(), strict=True
    ):
        secrets[name] = Path(path).read_text()
    machine.shell("install -d -m 0700 /etc/credstore")
    for name, text in secrets.items():
        machine.shell(f"umask 077; cat >/etc/credstore/rf-nav.{name} <<'END'\n{text}END")
    laptop = certified(tmp_path, "laptop", "127.0.0.1")
    robot = LabelledRobot(BusConfig(listen=(f"tls/127.0.0.1:{port}",), tls=laptop))
    robot.start()
    try:
        life.configure(CLOUD + CERTIFICATES, f"tls/127.0.0.1:{port}")
        machine.shell("systemctl restart rf-nav-guard rf-nav")
        assert robot.ask("goal", {"goal": "chair"})["accepted"]
        robot.until(lambda: robot.commands and robot.commands[-1] != STILL)
        robot.until(lambda: "guard" not in robot.state()["runtime"]["cause"])  # it reaches somebody
        machine.shell("systemctl kill --kill-whom=main -s KILL rf-nav")
        robot.until(lambda: robot.commands[-1] == STILL)
    finally:
        robot.close()
    machine.shell("rm -r /etc/credstore")
    assert machine.run("systemctl", "restart", "rf-nav").returncode != 0
    told = r"bus\.tls\.ca: \S+rf-nav\.ca\.pem: No such file|cloud\.credential: must name a file"
    assert re.search(told, machine.journal())


def test_troubles_every_20_s_are_outlived_with_a_result_for_every_goal(
    life: Life, tmp_path: Path
) -> None:
    machine, port, state = life.machine, free_port(), "/var/lib/rf-nav"
    machine.shell(f"cat >{CONFIG} <<'END'\n{BUS.format(endpoint=f'tcp/127.0.0.1:{port}')}END")
    machine.shell(
        f"systemctl stop rf-nav; cp -a {state} /kept; mount -t tmpfs -o size=400m state {state};"
        f" cp -a /kept/. {state}; rm -r /kept; systemctl start --no-block rf-nav"
    )
    seen = machine.seen(state)
    soak = ["--minutes", MINUTES, "--unit", "rf-nav.service", "--within", " ".join(machine.within)]
    soak += ["--listen", f"tcp/127.0.0.1:{port}", "--state", str(seen), "--full-disk", str(seen)]
    command = [sys.executable, "-m", "hil_sim", "soak", *soak, "--out", str(tmp_path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr + machine.journal()
    finally:
        machine.shell(f"systemctl stop rf-nav; umount -l {state}; systemctl reset-failed rf-nav")


def test_given_up_it_rests_is_tried_again_and_who_stops_it_meanwhile_is_heeded(life: Life) -> None:
    machine = life.machine
    machine.shell("systemctl stop rf-nav; systemctl reset-failed rf-nav")
    once = "/run/systemd/system/rf-nav.service.d"
    machine.shell(f"mkdir -p {once}; printf '[Unit]\\nStartLimitBurst=1\\n' >{once}/once.conf")
    machine.shell("systemctl daemon-reload; systemctl start --no-block rf-nav")
    machine.until("systemctl is-active -q rf-nav-again")
    assert life.property("ActiveState") == "failed"
    machine.shell("systemctl stop rf-nav")
    assert life.property("ActiveState", "rf-nav-again") == "inactive"
    life.configure()
    machine.shell(f"rm -r {once}; systemctl daemon-reload; systemctl reset-failed rf-nav")
    machine.shell("systemctl start rf-nav")


def test_it_is_upgraded_and_goes_back(life: Life) -> None:
    machine = life.machine
    was = machine.shell("readlink /opt/rf-nav/current")
    done = machine.run("/bundle/install.sh", "--wheel", "/newer/" + newest(machine))
    assert done.returncode == 0, done.stderr
    assert machine.shell("readlink /opt/rf-nav/current").startswith("99.0.0-")
    assert machine.shell("readlink /opt/rf-nav/previous") == was
    life.ready()
    assert "/opt/rf-nav/99.0.0-" in running(life)
    assert f"tcp/127.0.0.1:{life.port}" in machine.shell(f"cat {CONFIG}")
    life.drives()

    back = machine.run(ROLLBACK, "--rollback")
    assert back.returncode == 0, back.stderr
    assert machine.shell("readlink /opt/rf-nav/current") == was
    assert f"/opt/rf-nav/{was}/" in running(life)
    life.ready()


def test_one_that_does_not_start_is_told_with_the_way_back(life: Life) -> None:
    life.machine.shell(f"echo '[' >{CONFIG}")
    done = life.machine.run(ROLLBACK, "--rollback")
    assert done.returncode == 1
    assert re.search(r"99\.0\.0-\w+ does not start: .*; back: .*--rollback\n", done.stderr)
    life.configure()
    done = life.machine.run(ROLLBACK, "--rollback")
    assert done.returncode == 0, done.stderr
    life.ready()
    life.drives()


def newest(machine: Machine) -> str:
    return machine.shell("ls /newer")


def running(life: Life) -> str:
    return life.machine.shell(
        "readlink /proc/$(systemctl show -p MainPID --value rf-nav)/exe; "
        "tr '\\0' ' ' </proc/$(systemctl show -p MainPID --value rf-nav)/cmdline"
    )


def test_removed_what_it_learnt_is_left_and_purged_nothing_is(life: Life) -> None:
    machine = life.machine
    done = machine.run("/opt/rf-nav/current/share/rf-nav/uninstall.sh")
    assert done.returncode == 0, done.stderr
    life.robot.until(lambda: life.robot.commands[-1] == STILL)  # it drove
    assert machine.shell(f"ls {CONFIG}; ls -d /var/lib/rf-nav/searches")
    assert machine.run("ls", "/opt/rf-nav").returncode != 0
    assert machine.told("systemctl", "list-unit-files", "--no-legend", "rf-nav*") == ""
    done = machine.run("/bundle/uninstall.sh", "--purge")
    assert (done.returncode, done.stderr) == (0, "uninstall: nothing is left\n")
    assert machine.shell(EVERYTHING).splitlines() == life.before
    assert machine.run("id", "rf-nav").returncode != 0
