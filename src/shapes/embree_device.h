#pragma once

#include "shapes/embree.h"

#include <atomic>
#include <cstddef>
#include <memory>

namespace cuticle {

// Embree's device, one for all sets of the process, because each device takes thread-specific keys from the
// system, of which there are about a thousand, and a scene may define more objects than that. It closes with
// the last set that holds it.
class EmbreeDevice {
  public:
    // Throws Error where Embree cannot start.
    static std::shared_ptr<EmbreeDevice> Shared();
    ~EmbreeDevice() { rtcReleaseDevice(device_); }
    EmbreeDevice(const EmbreeDevice &) = delete;
    EmbreeDevice &operator=(const EmbreeDevice &) = delete;

    operator RTCDevice() const { return device_; }
    // Returns how many bytes Embree holds for all sets together.
    ptrdiff_t Bytes() const { return bytes_.load(std::memory_order_relaxed); }
    // Throws Error("Embree: <what>: ...") if this thread's last call failed.
    void Check(const char *what) const;

  private:
    EmbreeDevice();
    std::atomic<ptrdiff_t> bytes_{0};
    RTCDevice device_ = nullptr;
};

// Adds to a set's account what Embree takes while this object lives. Sets are built one after another; if two
// were built at once, each might be billed for parts of the other.
class EmbreeMemoryScope {
  public:
    EmbreeMemoryScope(const EmbreeDevice &device, ptrdiff_t *account)
        : device_(device), account_(account), before_(device.Bytes()) {}
    ~EmbreeMemoryScope() { *account_ += device_.Bytes() - before_; }
    EmbreeMemoryScope(const EmbreeMemoryScope &) = delete;
    EmbreeMemoryScope &operator=(const EmbreeMemoryScope &) = delete;

  private:
    const EmbreeDevice &device_;
    ptrdiff_t *account_;
    ptrdiff_t before_;
};

} // namespace cuticle
