"""Order of the gallery's pages below each topic: from what a reader needs first."""

from sphinx_gallery.sorting import FileNameSortKey

FIRST = (
    *("plot_lighting", "plot_vehicles", "plot_distractors", "plot_flow_and_depth"),
    *("one_pixel", "plot_sensors", "plot_noise", "plot_s_curve"),
    *("plot_intermediate_maps", "plot_time_surfaces", "plot_attention", "plot_rivals"),
    *("plot_own_video", "plot_real_recording", "plot_robot_arm"),
)


class GalleryOrder(FileNameSortKey):
    """Sort pages in the order of `FIRST`, and others behind them by name."""

    def __call__(self, filename: str) -> str:
        """Return the key of a page."""
        name = str(filename).removesuffix(".py")
        number = FIRST.index(name) if name in FIRST else len(FIRST)
        return f"{number:02} {name}"
