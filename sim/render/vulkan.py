"""List of this machine's Vulkan devices, read from the Vulkan loader.

Filament aborts the whole process if it finds no device, so flybench checks before it starts
Filament.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys
from dataclasses import dataclass

from sim.errors import RendererError

INSTALL_COMMAND = "apt-get install -y libvulkan1 mesa-vulkan-drivers"
VECTOR_WIDTH = "LP_NATIVE_VECTOR_WIDTH"
"""Environment variable that sets the width of the software renderer's vectors [bit]."""
WORKING_VECTOR_WIDTH = 256
"""The width that works. With 0, 64 and 128, Mesa 22.3.6 corrupts memory as
soon as there are shadows, also in a program that uses nothing but MuJoCo. With 512, it crashes at
the first image on a processor with AVX-512 (measured)."""
_TYPE_CPU = 4  # VK_PHYSICAL_DEVICE_TYPE_CPU
_VULKAN_1_1 = 1 << 22 | 1 << 12


@dataclass(frozen=True)
class VulkanDevice:
    """A physical Vulkan device.

    Attributes:
        name: name of the device.
        driver: name and version of its driver.
        is_software: True if the device is a CPU that renders in software.
    """

    name: str
    driver: str
    is_software: bool


class _ApplicationInfo(ctypes.Structure):
    """VkApplicationInfo."""

    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("pApplicationName", ctypes.c_char_p),
        ("applicationVersion", ctypes.c_uint32),
        ("pEngineName", ctypes.c_char_p),
        ("engineVersion", ctypes.c_uint32),
        ("apiVersion", ctypes.c_uint32),
    )


class _DriverProperties(ctypes.Structure):
    """VkPhysicalDeviceDriverProperties."""

    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("driverID", ctypes.c_uint32),
        ("driverName", ctypes.c_char * 256),
        ("driverInfo", ctypes.c_char * 256),
        ("conformanceVersion", ctypes.c_uint8 * 4),
    )


class _DeviceProperties(ctypes.Structure):
    """VkPhysicalDeviceProperties2; its limits and features are unread bytes, with a margin."""

    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("apiVersion", ctypes.c_uint32),
        ("driverVersion", ctypes.c_uint32),
        ("vendorID", ctypes.c_uint32),
        ("deviceID", ctypes.c_uint32),
        ("deviceType", ctypes.c_uint32),
        ("deviceName", ctypes.c_char * 256),
        ("rest", ctypes.c_uint8 * 4096),
    )


class _InstanceInfo(ctypes.Structure):
    """VkInstanceCreateInfo."""

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
    """Return all Vulkan devices; none if the loader or a driver is missing."""
    name = ctypes.util.find_library("vulkan")
    if name is None:
        return []
    vulkan = ctypes.CDLL(name)
    instance = ctypes.c_void_p()
    application = _ApplicationInfo(sType=0, apiVersion=_VULKAN_1_1)
    info = _InstanceInfo(
        sType=1, pApplicationInfo=ctypes.cast(ctypes.pointer(application), ctypes.c_void_p)
    )
    if vulkan.vkCreateInstance(ctypes.byref(info), None, ctypes.byref(instance)) != 0:
        return []
    try:
        return [_describe(vulkan, handle) for handle in _handles(vulkan, instance)]
    finally:
        vulkan.vkDestroyInstance(instance, None)


def require_vulkan() -> bool:
    """Check that this machine has a Vulkan device.

    Returns:
        True if every device renders in software. Always False on other systems than Linux, where
        devices are not checked.

    Raises:
        RendererError: this is Linux, and there is no Vulkan device, or its software renderer is
            set to vectors with which it fails.
    """
    if not sys.platform.startswith("linux"):
        return False
    devices = vulkan_devices()
    if not devices:
        raise RendererError(
            "found no Vulkan device. Rendering needs one; a software driver on the CPU is enough. "
            f"Install a driver with `sudo {INSTALL_COMMAND}` (Debian, Ubuntu)."
        )
    software = all(device.is_software for device in devices)
    if software and (problem := vector_width_problem()):
        raise RendererError(problem)
    return software


def vector_width_problem() -> str | None:
    """Return what is wrong with `LP_NATIVE_VECTOR_WIDTH` and what to do; None: nothing is."""
    value = os.environ.get(VECTOR_WIDTH, "")
    try:
        works = int(value, 0) == WORKING_VECTOR_WIDTH
    except ValueError:  # Mesa ignores what is not a number
        return None
    if works:
        return None
    return (
        f"{VECTOR_WIDTH} is {value}, with which Mesa's software renderer can crash the program. "
        f"Allowed is {WORKING_VECTOR_WIDTH}. Unset the variable."
    )


def _handles(vulkan: ctypes.CDLL, instance: ctypes.c_void_p) -> list[ctypes.c_void_p]:
    count = ctypes.c_uint32()
    vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), None)
    handles = (ctypes.c_void_p * count.value)()
    vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), handles)
    return [ctypes.c_void_p(handle) for handle in handles]


def _describe(vulkan: ctypes.CDLL, handle: ctypes.c_void_p) -> VulkanDevice:
    driver = _DriverProperties(sType=1000196000)
    chained = ctypes.cast(ctypes.pointer(driver), ctypes.c_void_p)
    device = _DeviceProperties(sType=1000059001, pNext=chained)
    vulkan.vkGetPhysicalDeviceProperties2(handle, ctypes.byref(device))
    return VulkanDevice(
        name=device.deviceName.decode(),
        driver=f"{driver.driverName.decode()}, {driver.driverInfo.decode()}",
        is_software=device.deviceType == _TYPE_CPU,
    )
