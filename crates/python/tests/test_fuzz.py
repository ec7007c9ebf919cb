"""A few thousand frames at random."""

from fuzz import run


def test_frames_at_random() -> None:
    taken = run(3000, seed=1)
    assert 100 < taken < 2900, taken
