// Memory in pages of 2 MB, for data that is read in no foreseeable order.
#pragma once

#include <cstddef>
#include <cstdint>
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
// What was never written of a large block takes no memory. Throws std::bad_alloc where there is none.
class LargePages {
  public:
    LargePages() = default;
    explicit LargePages(size_t size) : size_(size) {
#ifdef __linux__
        if (size >= kPage) {
            Map();
            return;
        }
#endif
        const size_t alignment = size >= kPage ? kPage : 64;
        const size_t rounded = RoundUp(size, alignment);
        data_ = static_cast<unsigned char *>(std::aligned_alloc(alignment, rounded));
        if (!data_)
            throw std::bad_alloc();
        std::memset(data_, 0, rounded);
    }
    LargePages(LargePages &&o) noexcept : data_(o.data_), size_(o.size_) { o.data_ = nullptr, o.size_ = 0; }
    LargePages &operator=(LargePages &&o) noexcept {
        std::swap(data_, o.data_), std::swap(size_, o.size_);
        return *this;
    }
    ~LargePages() {
#ifdef __linux__
        if (size_ >= kPage) {
            ::munmap(data_, RoundUp(size_, kPage));
            return;
        }
#endif
        std::free(data_);
    }
    unsigned char *Data() const { return data_; }
    size_t Size() const { return size_; } // in bytes
    static constexpr size_t kPage = size_t(1) << 21;

  private:
    static size_t RoundUp(size_t size, size_t to) { return (size + to - 1) / to * to; }

#ifdef __linux__
    // Maps a page more than is needed and gives back what lies outside whole pages.
    void Map() {
        const size_t rounded = RoundUp(size_, kPage);
        void *const m =
            ::mmap(nullptr, rounded + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (m == MAP_FAILED)
            throw std::bad_alloc();
        auto *const begin = static_cast<unsigned char *>(m);
        const size_t before = (kPage - reinterpret_cast<uintptr_t>(m) % kPage) % kPage;
        if (before > 0)
            ::munmap(begin, before);
        ::munmap(begin + before + rounded, kPage - before);
        data_ = begin + before;
        ::madvise(data_, rounded, MADV_HUGEPAGE); // a wish: without it all works, slower
    }
#endif

    unsigned char *data_ = nullptr;
    size_t size_ = 0;
};

} // namespace cuticle
