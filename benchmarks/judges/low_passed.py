"""Drives whose noisy channels a filter has smoothed, as that of a robot or a driver does."""

from __future__ import annotations

import argparse

from softsoil.recording.drive import Recording
from softsoil.recording.noise import low_pass


def add_filter_options(parser: argparse.ArgumentParser) -> None:
    """--low-pass SECONDS CHANNEL ... and --both-ways, which `filtered` takes."""
    parser.add_argument("--low-pass", nargs="+", metavar=("SECONDS", "CHANNEL"), help="of channels, behind their noise")
    parser.add_argument("--both-ways", action="store_true", help="the low-pass backwards as well")


def filtered(noisy: Recording, options: argparse.Namespace) -> Recording:
    """The drive with the low-pass of `options`, if any, behind the noise of its channels."""
    seconds, *names = options.low_pass or ["0"]
    made = {name: low_pass(noisy[name], noisy.dt, float(seconds), options.both_ways) for name in names}
    return noisy.with_channels(**made)
