from scenarios.pipeline.registry import DETECTORS, FLY, FRAME_FLY
from scenarios.study.figures.method_style import in_order, method_style


def test_methods_of_ours_differ_in_name_colour_and_marker() -> None:
    styles = [method_style(method) for method in DETECTORS]
    for values in zip(*((s.label, s.colour, s.marker) for s in styles), strict=True):
        assert len(set(values)) == len(styles)


def test_a_method_of_the_users_goes_by_its_name_and_looks_the_same_each_time() -> None:
    assert method_style("a.b:C").label == "a.b:C"
    assert method_style("a.b:C") == method_style("a.b:C")
    ours = {method_style(method).colour for method in DETECTORS}
    assert method_style("a.b:C").colour not in ours


def test_the_fly_comes_first_and_the_users_last() -> None:
    assert in_order(["x:Y", FRAME_FLY, FLY, FRAME_FLY]) == [FLY, FRAME_FLY, "x:Y"]
