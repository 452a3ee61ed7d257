#include "shapes/embree_device.h"

#include "core/error.h"

#include <mutex>

namespace cuticle {

EmbreeDevice::EmbreeDevice() : device_(rtcNewDevice(nullptr)) {
    if (!device_)
        throw Error("Embree cannot start (error {})", int(rtcGetDeviceError(nullptr)));
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void *counter, ssize_t bytes, bool) {
            static_cast<std::atomic<ptrdiff_t> *>(counter)->fetch_add(bytes, std::memory_order_relaxed);
            return true;
        },
        &bytes_);
}

std::shared_ptr<EmbreeDevice> EmbreeDevice::Shared() {
    static std::mutex mutex;
    static std::weak_ptr<EmbreeDevice> shared;
    const std::lock_guard<std::mutex> lock(mutex);
    std::shared_ptr<EmbreeDevice> device = shared.lock();
    if (!device)
        shared = device = std::shared_ptr<EmbreeDevice>(new EmbreeDevice);
    return device;
}

void EmbreeDevice::Check(const char *what) const {
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        throw Error("Embree: {}: out of memory", what);
    if (error != RTC_ERROR_NONE)
        throw Error("Embree: {}: error {}", what, int(error));
}

} // namespace cuticle
