from scenarios.output.colours import OFF, ON, hex_of, rgb_of


def test_a_colour_is_written_as_html_takes_it_and_read() -> None:
    assert (hex_of(ON), hex_of(OFF)) == ("#0072b2", "#d55e00")
    assert rgb_of("#D55E00") == OFF
