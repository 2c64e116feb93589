"""The frame-based fly of Fu and Yue (2020), which takes APS frames."""
