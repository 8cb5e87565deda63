"""Places that cannot be repaired are slowed down by themselves, and nothing else is."""

import numpy as np

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.trajectory.repair import slow_down_locally


def smooth_rows(n: int = 4001) -> np.ndarray:
    """A smooth profile from rest to rest, in rows."""
    u = np.linspace(0.0, 1.0, n)
    return 100.0 * u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)


def test_rows_outside_stay_and_the_place_is_slower_by_what_is_asked() -> None:
    s = smooth_rows()
    slower = np.ones(len(s))
    slower[2000:2010] = 1.5
    found = slow_down_locally(s, slower, 100)
    more = len(found) - len(s)
    assert more > 0
    # the bell reaches 150 rows to each side of the widened place
    assert np.array_equal(found[:1750], s[:1750])
    assert np.array_equal(found[-1750:], s[-1750:])
    assert (np.diff(found) > 0)[1:-1].all()
    middle = np.searchsorted(found, s[2005])
    before, after = s[2006] - s[2005], found[middle + 1] - found[middle]
    assert after <= before / 1.5
    # braking by a third and back over 75 rows each: the step times (1 / 1.5) (pi / 75)^2 or so, no seams
    assert np.abs(np.diff(found, 3)).max() < before * 0.5 * (np.pi / 75) ** 2


def test_nothing_asked_is_nothing_changed() -> None:
    s = smooth_rows()
    assert np.array_equal(slow_down_locally(s, np.ones(len(s)), 50), s)


def test_places_at_the_ends_keep_the_ends() -> None:
    s = smooth_rows(801)
    slower = np.ones(len(s))
    slower[[3, -4]] = 2.0
    found = slow_down_locally(s, slower, 60)
    assert found[0] == s[0]
    assert found[-1] == s[-1]
    assert (np.diff(found) >= 0).all()


def test_one_sharp_corner_does_not_slow_a_whole_program_at_a_fine_cycle() -> None:
    """A fast rapid into a slow feed: rows every 125 us see more of a corner than rows every millisecond."""
    machine = verne_post.load_machine("verne")
    source = (
        b"G21 G90 G94\nG0 X-40 Y0 Z90 A20 C0\nX40 Z40\nG1 X41 Y6 C4 F1200\nX41.5 Y12 C9\nX60 Y14 F6000\nG0 X-30 "
        b"Z80\nM2\n"
    )
    took = []
    for cycle in (0.001, 0.000125):
        options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, cycle=cycle)
        result = verne_post.convert(source, machine, options)
        assert result.ok, result.findings
        took.append(result.setpoints.t[-1])
    assert took[1] < 1.1 * took[0]
