"""In place of a screen: switches a simulated LinuxCNC on, homes it, runs the program of its folder, and leaves.

LinuxCNC starts this with the interpreter of the system, which has its module; results go to result.json.
"""

import json
import time
from pathlib import Path

import linuxcnc  # only in LinuxCNC's own Python

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
said: list[str] = []


def wait(test, seconds: float) -> bool:
    """Wait until ``test`` holds, collecting what LinuxCNC says."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        message = errors.poll()
        if message:
            said.append(message[1])
        if test():
            return True
        time.sleep(0.02)
    return False


def set_up() -> bool:
    """Switch on and home."""
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    if not wait(lambda: status.task_state == linuxcnc.STATE_ON, 20):
        return False
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.home(-1)
    if not wait(lambda: sum(status.homed[:5]) == 5, 20):
        return False
    command.teleop_enable(1)
    command.mode(linuxcnc.MODE_AUTO)
    return wait(lambda: status.task_mode == linuxcnc.MODE_AUTO, 20)


def run_program() -> bool:
    """Run the program to its end, or to the first error."""
    command.program_open(str(Path("program.ngc").resolve()))
    command.auto(linuxcnc.AUTO_RUN, 0)
    wait(lambda: status.interp_state != linuxcnc.INTERP_IDLE, 2)
    ended = wait(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and not status.queue, 900)
    return ended and wait(lambda: True, 1) and not said


done = set_up() and run_program()
Path("result.json").write_text(
    json.dumps({"done": done, "said": said, "joints": status.joint_position[:5], "world": status.position[:6]}),
    encoding="utf-8",
)
