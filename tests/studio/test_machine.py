"""The description of the machine is complete and goes into JSON."""

from __future__ import annotations

import json
import platform

from belvedere.studio.machine import describe_machine


def test_the_machine_is_described_by_what_speed_depends_on() -> None:
    machine = describe_machine(threads=2)
    assert machine.threads == 2
    assert machine.cores >= 1
    assert machine.python.endswith(platform.python_version())
    assert machine.packages["numba"] != "none"
    assert json.loads(json.dumps(machine.as_dict()))["cpu"] == machine.cpu
    assert machine.cpu in machine.summary()


def test_the_description_names_no_host() -> None:
    node = platform.node()
    assert not node or node not in json.dumps(describe_machine().as_dict())
