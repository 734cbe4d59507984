"""Recordings and tables of a bouncing ball."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from restitution import checks
from restitution.case.observations import REBOUND_COLUMNS, open_columns, read_observations, rebounds_in
from restitution.case.quantity import in_si
from restitution.checks import Array
from restitution.errors import InputError
from restitution.files import path_of, readable_again
from restitution.identification.bounce_series import UNKNOWN, Ball, MeasuredBounces, from_instants, from_rebounds
from restitution.identification.impacts import Rebounds
from restitution.identification.sound import Picks, find_bounces, read_wav
from restitution.impact.problem import STANDARD_GRAVITY
from restitution.material.sheet import FileError, decoded, is_number, read_bytes, split_lines
from restitution.units import TIME

_FEWEST = 3


def read_bounces(
    path: str | Path,
    *,
    radius: Any = None,
    mass: Any = None,
    contact_time: Any = None,
    gravity: Any = STANDARD_GRAVITY,
    air_density: Any = 1.2,
    drag_coefficient: Any = 0.47,
) -> MeasuredBounces:
    r"""Return the bounces of a ball in a sound, in labels of Audacity, or in a table of instants, heights or speeds.

    Parameters
    ----------
    path : path-like
        A WAV file, in which the touches are found. Or labels of Audacity, whose beginnings are instants of touch. Or a
        CSV file with the columns `time` (others are not read, but for `sd_time`), `drop_height` and `rebound_height`,
        `v_in` and `v_out`, or `velocity` and `restitution_coefficient`, as in `read_observations`.
    radius : float, optional
        Radius R [m] of the ball.
    mass : float, optional
        Mass m [kg]. With the radius it gives the drag of air, and with a contact time the moduli.
    contact_time : float, optional
        Contact time [s], measured in the first bounce that has a restitution coefficient, which is the second touch of
        a sound; a table of rebounds has a column instead.
    gravity : float
        Acceleration of free fall [m/s^2].
    air_density : float
        Density of the air [kg/m^3]; 0 for no drag. Heights and speeds are not corrected for it.
    drag_coefficient : float
        Drag coefficient of the ball [-].

    Returns
    -------
    MeasuredBounces
        e and the loss tangent of each bounce, with standard errors.

    Raises
    ------
    InputError
        If the file is malformed, has no series of bounces, or a number is out of range.

    Notes
    -----
    The restitution coefficient is the velocity after a bounce, from the interval behind it, over that before it, from
    the interval before it: ``e = (t3 - t2)/(t2 - t1)`` but for the contact time and the drag. Every sound comes late
    by the way to the microphone; only changes of this way during the bounces count.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "labels.txt")
    ...     _ = file.write_text("0.5\t0.5\tone\n1.0\t1.0\ttwo\n1.4\t1.4\t\n1.72\t1.72\t\n")
    ...     read_bounces(file).restitution_coefficient.round(3)
    array([nan, 0.8, 0.8, nan])
    """
    source = path_of(path)
    ball = Ball(radius, mass, contact_time, gravity, air_density, drag_coefficient).checked()
    with readable_again(source) as file:
        try:
            return _read(file, ball)
        except FileError as error:
            raise InputError(error.field, rule=error.rule, where=str(source)) from None
        except InputError as error:
            raise error.within(where=(error.where or str(source)).replace(str(file), str(source))) from None


def _read(source: Path, ball: Ball) -> MeasuredBounces:
    if _is_wav(source):
        recording = read_wav(source)
        return from_instants(find_bounces(recording), ball, recording)
    if (time := _labels(source)) is not None:
        return from_instants(_picks(time, None), ball)
    sheet, names = open_columns(source)
    if "time" not in names and not any(rebounds_in(names)):
        raise FileError("", sheet.header_line, f"must have the columns time, or {REBOUND_COLUMNS}")
    if "time" not in names or {"force", "acceleration", "depth"} & {*names}:
        return _of_table(source, names, ball)
    columns = [in_si(sheet, names.index(name), name, TIME) for name in ("time", "sd_time") if name in names]
    return from_instants(_picks(*columns, *([None] if len(columns) == 1 else [])), ball)


def _is_wav(source: Path) -> bool:
    """Return whether a file is a sound, by its name or its first letters."""
    if source.suffix.lower() in (".wav", ".wave"):
        return True
    if source.suffix.lower() == ".toml" and source.is_file():
        raise InputError("", rule="is a case file, no recording; `restitution bounce` lets its body bounce")
    if source.suffix.lower() in (".mp3", ".m4a", ".aac", ".ogg", ".flac", ".opus", ".mp4", ".mov"):
        raise InputError("", rule="must be a WAV file: convert the sound, for example with Audacity")
    try:
        with source.open("rb") as file:
            return file.read(4) in (b"RIFF", b"RIFX", b"RF64")
    except OSError:
        return False  # the reader of tables has the message


def _labels(source: Path) -> Array | None:
    """Return the beginnings of labels of Audacity; None if the file is something else.

    A label is a line of two times and a text between tabulators; lines of a frequency range begin with a backslash.
    """
    lines = split_lines(decoded("", read_bytes(source)), " ")
    texts = [line.text for line in lines if line.text.strip() and not line.text.startswith("\\")]
    cells = [text.split("\t") for text in texts]
    if not cells or not all(len(row) in (2, 3) and all(map(is_number, row[:2])) for row in cells):
        return None
    if any(float(row[1].replace(",", ".")) < float(row[0].replace(",", ".")) for row in cells):
        return None
    return np.array([float(row[0].replace(",", ".")) for row in cells])


def _picks(time: Array, error: Array | None) -> Picks:
    """Return instants as picks; their errors are NaN if they are not known."""
    if time.size < _FEWEST:
        raise InputError("time", rule=f"must have at least {_FEWEST} instants, not {time.size}")
    if np.any(np.diff(time) <= 0.0):
        place = int(np.argmax(np.diff(time) <= 0.0)) + 1
        raise InputError("time", float(time[place]), "must be strictly ascending", "s", index=(place,))
    unknown = np.full(time.size, np.nan)
    if error is not None:
        checks.positive("sd_time", error, "s")
    return Picks(time, unknown if error is None else error, unknown)


def _of_table(source: Path, names: list[str], ball: Ball) -> MeasuredBounces:
    """Return the bounces of a table of rebounds; a missing radius or mass is no obstacle to e."""
    if ball.contact_time is not None:
        rule = "must be a column of the table: contact times of bounces at given velocities differ"
        raise InputError("contact_time", ball.contact_time, rule, "s")
    sizes = {name: getattr(ball, name) for name in ("radius", "mass") if name not in names}
    for name in ("radius", "mass"):
        if name in names and getattr(ball, name) is not None:
            raise InputError(name, getattr(ball, name), "is a column of the table: must be given once")
    is_sized = all(size is not None for size in sizes.values())
    assumed: dict[str, Any] = {
        name: default if sizes[name] is None else sizes[name]
        for name, default in zip(("radius", "mass"), UNKNOWN, strict=True)
        if name in sizes
    }
    rebounds = read_observations(source, kind="rebounds", **assumed)
    assert isinstance(rebounds, Rebounds)
    return from_rebounds(rebounds, sized=is_sized)
