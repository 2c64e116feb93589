"""What this machine can render with."""

from __future__ import annotations

import pytest

from sim.errors import RendererError
from sim.render.vulkan import VECTOR_WIDTH, VulkanDevice, require_vulkan, vector_width_problem


def devices(monkeypatch: pytest.MonkeyPatch, *, software: bool) -> None:
    device = VulkanDevice("a device", "a driver", software)
    monkeypatch.setattr("sim.render.vulkan.vulkan_devices", lambda: [device])


@pytest.mark.parametrize("width", ["0", "64", "128", "0x80", "-1", "512"])
def test_vectors_that_crash_are_refused(monkeypatch: pytest.MonkeyPatch, width: str) -> None:
    devices(monkeypatch, software=True)
    monkeypatch.setenv(VECTOR_WIDTH, width)
    with pytest.raises(RendererError, match=f"{VECTOR_WIDTH} is {width}.*Allowed is 256"):
        require_vulkan()


@pytest.mark.parametrize("width", ["256", "0x100", "", "wide"])
def test_other_values_are_allowed(monkeypatch: pytest.MonkeyPatch, width: str) -> None:
    devices(monkeypatch, software=True)
    monkeypatch.setenv(VECTOR_WIDTH, width)
    assert require_vulkan()
    assert vector_width_problem() is None


def test_a_hardware_device_does_not_use_the_width(monkeypatch: pytest.MonkeyPatch) -> None:
    devices(monkeypatch, software=False)
    monkeypatch.setenv(VECTOR_WIDTH, "128")
    assert not require_vulkan()
