//> Declare the list of segments
#pragma once

#include "core/large_pages.h"
#include "shapes/curve_set_kernel.h"
#include "shapes/curve_types.h"

#include <initializer_list>
#include <iterator>
#include <vector>

namespace cuticle {

//> Keep the points of a strand once
// CurveList is a list of curve segments in which neighbours share what they have in common: a segment that
// begins where the one before it ends, with the same width and in the same group, belongs to its strand. What
// comes out is what was put in, bit for bit. Its functions have the names of std::vector's.
class CurveList {
  public:
    CurveList() = default;
    CurveList(const std::vector<CurveSegment> &segments) { Append(segments.data(), segments.size()); }
    CurveList(std::initializer_list<CurveSegment> segments) { Append(segments.begin(), segments.size()); }
    CurveList(const CurveList &list);
    CurveList &operator=(const CurveList &list) { return *this = CurveList(list); }
    CurveList(CurveList &&list) noexcept : CurveList() { *this = std::move(list); }
    CurveList &operator=(CurveList &&list) noexcept;

    size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    CurveSegment operator[](size_t i) const;
    CurveSegment at(size_t i) const; // throws std::out_of_range
    CurveSegment back() const { return (*this)[size_ - 1]; }
    void push_back(const CurveSegment &segment);
    void reserve(size_t segments);
    void shrink_to_fit();

    // Reads the segments in order.
    struct Iterator {
        using value_type = CurveSegment;
        using reference = CurveSegment;
        using pointer = void;
        using difference_type = std::ptrdiff_t;
        using iterator_category = std::input_iterator_tag;
        const CurveList *list;
        size_t i;
        CurveSegment operator*() const { return (*list)[i]; }
        Iterator &operator++() { return ++i, *this; }
        Iterator operator++(int) { return {list, i++}; }
        bool operator==(const Iterator &o) const { return i == o.i; }
    };
    Iterator begin() const { return {this, 0}; }
    Iterator end() const { return {this, size_}; }

    // Returns the index of the first of a segment's four points.
    size_t FirstPoint(size_t i) const;
    CurveSegment SegmentAtPoint(size_t first) const;
    const curve_kernel::CurvePoint *Points() const;
    size_t PointCount() const { return pointCount_; }
    const curve_kernel::StrandStarts *Starts() const { return starts_.data(); }
    size_t MemoryBytes() const;

  private:
    void Append(const CurveSegment *segments, size_t count);
    void Resize(size_t points);
    bool ContinuesStrand(const CurveSegment &segment) const;
    curve_kernel::CurvePoint *Point(size_t i);

    size_t size_ = 0, pointCount_ = 0;
    LargePages points_;
    std::vector<curve_kernel::StrandStarts> starts_; // of 64 segments each
    std::vector<uint32_t> groups_;                   // by strand
};
//<

} // namespace cuticle
//<
