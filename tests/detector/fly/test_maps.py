from detector.fly.maps import FlyMaps


def test_the_bounding_box_is_clipped_to_the_sensor() -> None:
    maps = FlyMaps.blank((5, 6), cell_px=3)
    maps.attended[1, 2] = maps.attended[4, 5] = True
    assert maps.bounding_box_px(width=17, height=14) == (6, 3, 17, 14)


def test_blank_maps_have_no_bounding_box() -> None:
    assert FlyMaps.blank((5, 6), cell_px=3).bounding_box_px(width=18, height=15) is None
