// Memory in pages of 2 MB, for data that is read in no foreseeable order.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace cuticle {

// LargePages owns a block of bytes, all zero at first, aligned to 64 bytes or, from 2 MB on, to a page of 2
// MB. Traversal jumps about in tens of megabytes; with large pages it waits less for address translation.
// Throws std::bad_alloc where there is no memory.
class LargePages {
  public:
    LargePages() = default;
    explicit LargePages(size_t size) : size_(size) {
        constexpr size_t page = size_t(1) << 21;
        const size_t alignment = size >= page ? page : 64;
        const size_t rounded = (size + alignment - 1) / alignment * alignment;
        data_ = static_cast<unsigned char *>(std::aligned_alloc(alignment, rounded));
        if (!data_)
            throw std::bad_alloc();
#ifdef __linux__
        if (size >= page)
            madvise(data_, rounded, MADV_HUGEPAGE); // a wish: without it all works, slower
#endif
        std::memset(data_, 0, rounded);
    }
    LargePages(LargePages &&o) noexcept : data_(o.data_), size_(o.size_) { o.data_ = nullptr, o.size_ = 0; }
    LargePages &operator=(LargePages &&o) noexcept {
        std::swap(data_, o.data_), std::swap(size_, o.size_);
        return *this;
    }
    ~LargePages() { std::free(data_); }
    unsigned char *Data() const { return data_; }
    size_t Size() const { return size_; } // in bytes

  private:
    unsigned char *data_ = nullptr;
    size_t size_ = 0;
};

} // namespace cuticle
