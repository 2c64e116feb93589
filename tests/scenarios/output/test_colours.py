from scenarios.output.colours import OFF, ON, hex_of


def test_a_colour_is_written_as_html_takes_it() -> None:
    assert (hex_of(ON), hex_of(OFF)) == ("#0072b2", "#d55e00")
