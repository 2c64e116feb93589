"""`flybench validate`: score detectors on windows of real recordings with known motion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import tyro

from scenarios.options.method import ALLOWED_METHODS
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import ProgressBars, progress_bar
from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import report_failures, run_cli
from scenarios.output.versions import versions
from scenarios.pipeline.registry import DETECTORS
from scenarios.pipeline.user_detectors import find_method
from scenarios.validate.event_image import event_images
from scenarios.validate.files import find_file
from scenarios.validate.keys import ManifestError
from scenarios.validate.manifest import PACKAGED, Manifest, Recording, read_manifest
from scenarios.validate.page import render_page
from scenarios.validate.results import WindowResult, failures, print_results, write_csv
from scenarios.validate.scoring import Score, score
from scenarios.validate.stimulus import check_recording, read_stimuli
from scenarios.validate.turns import TURNS, Turn

TABLE, PAGE = "results.csv", "report.html"
NEEDED_BYTES = 10_000_000
"""Room for the page with its images and the table [bytes] (assumed)."""


@dataclass(frozen=True)
class Validate:
    """Score detectors on real recordings with known motion."""

    REPEATABLE: ClassVar = frozenset({"--method", "--recording"})
    manifest: Annotated[
        Path | None,
        tyro.conf.Positional,
        tyro.conf.arg(
            metavar="MANIFEST.toml", help_behavior_hint="(default: three public recordings)"
        ),
    ] = None
    """List of recordings with true directions; see docs/explanation/real-recordings.md."""
    method: Annotated[
        tuple[str, ...],
        tyro.conf.arg(
            metavar="NAME",
            help=f"Name of a detector: {ALLOWED_METHODS}. Repeat the option to compare several.",
            help_behavior_hint="(default: all built-in detectors)",
        ),
        tyro.conf.UseAppendAction,
    ] = ()
    recording: Annotated[
        tuple[str, ...],
        tyro.conf.arg(metavar="NAME", help_behavior_hint="(default: all)"),
        tyro.conf.UseAppendAction,
    ] = ()
    """Name of a recording of the manifest. Repeat the option to choose several."""
    folder: Annotated[
        Path | None,
        tyro.conf.arg(metavar="DIR", help_behavior_hint="(default: fetch into the user's cache)"),
    ] = None
    """Folder that holds the files of all recordings. Nothing is fetched then."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("logs/validate")
    """Output folder; an earlier result in it is replaced."""

    def execute(self) -> int:
        """Find the files, run every method on every window, and write the folder."""
        methods = tuple(dict.fromkeys(self.method)) or tuple(DETECTORS)
        for name in methods:
            find_method(name)
        manifest = read_manifest(self.manifest or PACKAGED).select(self.recording)
        check_output_folder(self.out, needed_bytes=NEEDED_BYTES)
        with atomic_folder(self.out) as work:
            results = self._measure(manifest, methods)
            failed = failures(results)
            self._write(work, manifest, methods, results, failed)
        print_results(SafeConsole(), results)
        say(f"wrote {self.out / PAGE}")
        return report_failures(failed)

    def _measure(self, manifest: Manifest, methods: tuple[str, ...]) -> list[WindowResult]:
        """Find and check the files, then run every method on every window."""
        with progress_bar() as bars, _naming(manifest.path):
            files = [find_file(manifest, r, self.folder, bars.track) for r in manifest.recordings]
            for recording, path in zip(manifest.recordings, files, strict=True):
                check_recording(recording, path)
            return [
                result
                for recording, path in zip(manifest.recordings, files, strict=True)
                for result in _results(recording, path, methods, bars)
            ]

    def _write(
        self,
        work: Path,
        manifest: Manifest,
        methods: tuple[str, ...],
        results: list[WindowResult],
        failed: list[str],
    ) -> None:
        write_csv(work / TABLE, results)
        page = render_page(manifest, results, versions=versions())
        (work / PAGE).write_text(page, encoding="utf-8")
        facts = {r.name: {"sha256": r.sha256, "licence": r.licence} for r in manifest.recordings}
        summary = {"manifest": str(manifest.path), "methods": methods, "recordings": facts}
        summary |= {"failed": failed, "versions": versions()}
        write_summary(work, {"command": "validate", **summary})


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Put the path of the manifest before the messages of its errors."""
    try:
        yield
    except ManifestError as error:
        raise ManifestError(f"{path}: {error}") from error


def _results(
    recording: Recording, path: Path, methods: tuple[str, ...], bars: ProgressBars
) -> list[WindowResult]:
    """Run every method on every window of a recording."""
    advance = bars.track(recording.name)
    advance(0, 1)
    stimuli = read_stimuli(recording, path)
    results = []
    for number, (window, stimulus) in enumerate(zip(recording.windows, stimuli, strict=True), 1):
        scores: dict[str, dict[Turn, Score]] = {method: {} for method in methods}
        for turn in TURNS:
            turned, truth = turn.stimulus(stimulus), turn.direction(window.direction)
            for method in methods:
                scores[method][turn] = score(method, turned, truth)
        advance(number, len(stimuli))
        images = event_images(stimulus)
        results.append(
            WindowResult(recording, number, window, stimulus.duration_us, images, scores)
        )
    return results


if __name__ == "__main__":
    run_cli(Validate)
