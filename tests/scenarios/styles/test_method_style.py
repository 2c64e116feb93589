from scenarios.pipeline.registry import DETECTORS, FLY, FRAME_FLY
from scenarios.styles.method_style import in_display_order, method_style


def test_our_methods_differ_in_name_colour_and_marker() -> None:
    styles = [method_style(method) for method in DETECTORS]
    for values in zip(*((s.label, s.colour, s.marker) for s in styles), strict=True):
        assert len(set(values)) == len(styles)


def test_a_users_class_has_its_own_name_and_a_fixed_style() -> None:
    assert method_style("a.b:C").label == "a.b:C"
    assert method_style("a.b:C") == method_style("a.b:C")
    ours = {method_style(method).colour for method in DETECTORS}
    assert method_style("a.b:C").colour not in ours


def test_the_fly_comes_first_and_users_classes_last() -> None:
    assert in_display_order(["x:Y", FRAME_FLY, FLY, FRAME_FLY]) == [FLY, FRAME_FLY, "x:Y"]


def test_a_method_behind_a_filter_has_a_label_for_readers() -> None:
    assert method_style("stcf+fly").label == "stcf + event-driven fly"
    assert method_style("stcf+a.b:C").label == "stcf+a.b:C"
