#include "files/gzip.h"

#include "core/error.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

namespace cuticle {

bool IsGzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

// zlib's state, and the packed bytes that it has not been given yet.
struct GzipReader::Inflater {
    z_stream z{};
    std::string_view packed;
    bool atEnd = false;               // of all members
    uint64_t taken = 0, unpacked = 0; // bytes so far

    Inflater() {
        if (inflateInit2(&z, 16 + MAX_WBITS) != Z_OK) // 16: gzip, nothing else
            throw Error("cannot be unpacked: zlib cannot start");
    }
    ~Inflater() { inflateEnd(&z); }
    Inflater(const Inflater &) = delete;
    Inflater &operator=(const Inflater &) = delete;

    // Hands zlib what it takes of the packed bytes, and takes up to `size` unpacked ones.
    int Inflate(char *to, size_t size, size_t *got) {
        constexpr size_t kMaxGiven = size_t(1) << 30; // zlib counts in 32 bits
        const size_t given = std::min(packed.size(), kMaxGiven), room = std::min(size, kMaxGiven);
        z.next_in = reinterpret_cast<Bytef *>(const_cast<char *>(packed.data()));
        z.avail_in = static_cast<uInt>(given);
        z.next_out = reinterpret_cast<Bytef *>(to);
        z.avail_out = static_cast<uInt>(room);
        const int status = inflate(&z, Z_NO_FLUSH);
        packed.remove_prefix(given - z.avail_in);
        *got = room - z.avail_out;
        taken += given - z.avail_in, unpacked += *got;
        return status;
    }
};

GzipReader::GzipReader(Source source) : source_(std::move(source)), inflater_(new Inflater) {}

GzipReader::GzipReader(std::string_view packed)
    : GzipReader([rest = packed]() mutable { return std::exchange(rest, {}); }) {}

GzipReader::~GzipReader() = default;

size_t GzipReader::Read(char *to, size_t size) {
    Inflater &in = *inflater_;
    while (!in.atEnd) {
        if (in.packed.empty())
            in.packed = source_();
        const bool noMore = in.packed.empty();
        size_t got = 0;
        const int status = in.Inflate(to, size, &got);
        if (status == Z_STREAM_END) {
            // Another member may follow
            if (in.packed.empty())
                in.packed = source_();
            in.atEnd = in.packed.empty();
            if (!in.atEnd && inflateReset(&in.z) != Z_OK)
                throw Error("cannot be unpacked: zlib cannot go on");
        } else if (status != Z_OK && status != Z_BUF_ERROR) {
            throw Error("holds damaged gzip data{}", in.z.msg ? fmt::format(" ({})", in.z.msg) : "");
        } else if (noMore && got == 0) {
            throw Error("ends in the middle of its gzip data");
        }
        if (ExpandsTooFar(in.unpacked, in.taken))
            throw Error("unpacks to more than {} times its size, as no honest data do", kMaxExpansion);
        if (got > 0)
            return got;
    }
    return 0;
}

} // namespace cuticle
