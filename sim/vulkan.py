"""Which Vulkan devices this machine has, asked of the loader itself.

Filament ends the whole process where it finds no device, so this is asked first.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import sys
from dataclasses import dataclass

from sim.errors import RendererError

INSTALL_COMMAND = "apt-get install -y libvulkan1 mesa-vulkan-drivers"
_TYPE_CPU = 4  # VK_PHYSICAL_DEVICE_TYPE_CPU
_PROPERTIES_BYTES = 4096  # VkPhysicalDeviceProperties has 824; the rest is headroom
_NAME_OFFSET, _NAME_BYTES = 20, 256


@dataclass(frozen=True)
class VulkanDevice:
    """A physical device: its name, and whether it is a processor drawing in software."""

    name: str
    is_software: bool


class _InstanceInfo(ctypes.Structure):
    """VkInstanceCreateInfo with nothing asked for."""

    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("flags", ctypes.c_uint32),
        ("pApplicationInfo", ctypes.c_void_p),
        ("enabledLayerCount", ctypes.c_uint32),
        ("ppEnabledLayerNames", ctypes.c_void_p),
        ("enabledExtensionCount", ctypes.c_uint32),
        ("ppEnabledExtensionNames", ctypes.c_void_p),
    )


def vulkan_devices() -> list[VulkanDevice]:
    """All Vulkan devices; none where the loader or a driver is missing."""
    name = ctypes.util.find_library("vulkan")
    if name is None:
        return []
    vulkan = ctypes.CDLL(name)
    instance = ctypes.c_void_p()
    info = _InstanceInfo(sType=1)  # VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO
    if vulkan.vkCreateInstance(ctypes.byref(info), None, ctypes.byref(instance)) != 0:
        return []
    try:
        return [_describe(vulkan, handle) for handle in _handles(vulkan, instance)]
    finally:
        vulkan.vkDestroyInstance(instance, None)


def require_vulkan() -> bool:
    """Make sure that something renders here, and tell whether only software does.

    Raises:
        RendererError: on Linux, no Vulkan device.
    """
    if not sys.platform.startswith("linux"):
        return False
    devices = vulkan_devices()
    if not devices:
        raise RendererError(
            "found no Vulkan device; one is needed to render, a processor will do; install "
            f"a driver with `sudo {INSTALL_COMMAND}` (Debian, Ubuntu)"
        )
    return all(device.is_software for device in devices)


def _handles(vulkan: ctypes.CDLL, instance: ctypes.c_void_p) -> list[ctypes.c_void_p]:
    count = ctypes.c_uint32()
    vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), None)
    handles = (ctypes.c_void_p * count.value)()
    vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), handles)
    return [ctypes.c_void_p(handle) for handle in handles]


def _describe(vulkan: ctypes.CDLL, handle: ctypes.c_void_p) -> VulkanDevice:
    properties = ctypes.create_string_buffer(_PROPERTIES_BYTES)
    vulkan.vkGetPhysicalDeviceProperties(handle, properties)
    device_type = ctypes.c_uint32.from_buffer(properties, 16).value
    name = properties.raw[_NAME_OFFSET : _NAME_OFFSET + _NAME_BYTES].split(b"\0")[0].decode()
    return VulkanDevice(name, device_type == _TYPE_CPU)
