from scenarios.styles.lighting_style import lighting_style


def test_day_is_filled_and_night_is_hollow() -> None:
    assert lighting_style("day", "#123456")["markerfacecolor"] == "#123456"
    assert lighting_style("night", "#123456")["markerfacecolor"] == "white"
