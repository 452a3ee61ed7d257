// Unpacking gzip data piece by piece: the one reader for scenes, meshes and whatever else comes as .gz.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace cuticle {

// Whether bytes begin as gzip data do (RFC 1952: 0x1f, 0x8b).
bool IsGzip(std::string_view bytes);

// The one limit on what packed data may grow to, whatever packs them (gzip, PNG, EXR, ...): beyond
// kFreeExpansion bytes they are refused where they are also more than kMaxExpansion times their packed size.
// Numbers as text pack 2 to 20 times, pictures less: only data made to do harm pack better and are so large.
inline constexpr uint64_t kFreeExpansion = uint64_t(256) << 20, kMaxExpansion = 200;
inline bool ExpandsTooFar(uint64_t unpacked, uint64_t packed) {
    return unpacked > kFreeExpansion && unpacked / kMaxExpansion > packed;
}

// Unpacks gzip data from front to back. Members that follow one another (RFC 1952) are read as one; anything
// else behind the last one is refused, and so are data that expand too far.
class GzipReader {
  public:
    // The next packed bytes, empty at the end; they must stay valid until it is called again.
    using Source = std::function<std::string_view()>;

    explicit GzipReader(Source source);
    // All of the data in memory, which must outlive the reader.
    explicit GzipReader(std::string_view packed);
    ~GzipReader();
    GzipReader(const GzipReader &) = delete;
    GzipReader &operator=(const GzipReader &) = delete;

    // Unpacks up to `size` > 0 bytes; returns how many, 0 only at the end. Data that are damaged or end too
    // early throw Error without the file's name, "holds damaged gzip data (...)": the caller knows the place.
    size_t Read(char *to, size_t size);

  private:
    struct Inflater;
    Source source_;
    std::unique_ptr<Inflater> inflater_;
};

} // namespace cuticle
