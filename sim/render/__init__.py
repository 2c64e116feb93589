"""MuJoCo's Filament renderer with images in cd/m², and the Vulkan devices that it needs."""
