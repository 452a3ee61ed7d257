//> Define the list of segments
#include "shapes/curve_list.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

namespace cuticle {

using namespace curve_kernel;

static_assert(sizeof(CurvePoint) == 16);

//> Make room for points
// Returns the bytes that hold so many points.
static size_t PointBytes(size_t points) { return points * sizeof(CurvePoint); }

CurvePoint *CurveList::Point(size_t i) { return reinterpret_cast<CurvePoint *>(points_.Data()) + i; }
const CurvePoint *CurveList::Points() const { return reinterpret_cast<const CurvePoint *>(points_.Data()); }

void CurveList::Resize(size_t points) {
    LargePages pages(PointBytes(points));
    if (pointCount_ > 0)
        std::memcpy(pages.Data(), points_.Data(), PointBytes(pointCount_));
    points_ = std::move(pages);
}
// Large blocks take no memory before they are written, so there is no need to be exact.
void CurveList::reserve(size_t segments) {
    const size_t points = pointCount_ + 4 * (segments - std::min(segments, size_));
    if (PointBytes(points) > points_.Size())
        Resize(std::max(points, pointCount_ + pointCount_ / 2)); // of many small requests, few copies
}
void CurveList::shrink_to_fit() {
    if (points_.Size() < LargePages::kPage && PointBytes(pointCount_) < points_.Size())
        Resize(pointCount_);
    starts_.shrink_to_fit();
    groups_.shrink_to_fit();
}
size_t CurveList::MemoryBytes() const {
    const size_t used = PointBytes(pointCount_) + LargePages::kPage - 1;
    return std::min(points_.Size(), used / LargePages::kPage * LargePages::kPage) +
           starts_.capacity() * sizeof(StrandStarts) + groups_.capacity() * sizeof(uint32_t);
}
//<

//> Add a segment
// Compares bits, so that neither a zero's sign nor a NaN is lost.
bool CurveList::ContinuesStrand(const CurveSegment &segment) const {
    if (size_ == 0 || groups_.back() != segment.group)
        return false;
    CurvePoint start;
    std::memcpy(start.p, &segment.cp[0], sizeof start.p);
    start.word = std::bit_cast<uint32_t>(segment.width[0]);
    return std::memcmp(&start, Points() + pointCount_ - 1, sizeof start) == 0;
}
void CurveList::push_back(const CurveSegment &segment) {
    if (PointBytes(pointCount_ + 4) > points_.Size())
        Resize(std::max(2 * pointCount_, size_t(4)) + 4);
    if (size_ % 64 == 0)
        starts_.push_back({0, static_cast<uint32_t>(groups_.size())});
    const bool joined = ContinuesStrand(segment);
    if (!joined) {
        starts_.back().bits |= uint64_t(1) << size_ % 64;
        groups_.push_back(segment.group);
    }
    const uint32_t words[4] = {
        std::bit_cast<uint32_t>(segment.width[0]), static_cast<uint32_t>(groups_.size() - 1),
        std::bit_cast<uint32_t>(segment.part), std::bit_cast<uint32_t>(segment.width[1])};
    for (size_t k = joined ? 1 : 0; k < 4; ++k) {
        CurvePoint *const point = Point(pointCount_++);
        std::memcpy(point->p, &segment.cp[k], sizeof point->p);
        point->word = words[k];
    }
    ++size_;
}
void CurveList::Append(const CurveSegment *segments, size_t count) {
    reserve(size_ + count);
    for (size_t i = 0; i < count; ++i)
        push_back(segments[i]);
}
//<

//> Find a segment by its number
// Counts the strands that begin up to segment i; the last of them is its own.
size_t CurveList::FirstPoint(size_t i) const {
    const StrandStarts &starts = starts_[i / 64];
    const uint64_t upToIt = starts.bits << (63 - i % 64);
    return 3 * i + starts.before + static_cast<size_t>(std::popcount(upToIt)) - 1;
}
CurveSegment CurveList::operator[](size_t i) const { return SegmentAtPoint(FirstPoint(i)); }
CurveSegment CurveList::SegmentAtPoint(size_t first) const {
    const CurvePoint *const p = Points() + first;
    CurveSegment segment;
    for (size_t k = 0; k < 4; ++k)
        segment.cp[k] = {p[k].p[0], p[k].p[1], p[k].p[2]};
    segment.width[0] = std::bit_cast<float>(p[0].word);
    segment.width[1] = std::bit_cast<float>(p[3].word);
    segment.group = groups_[p[1].word];
    segment.part = std::bit_cast<StrandPart>(p[2].word);
    return segment;
}
CurveSegment CurveList::at(size_t i) const {
    if (i >= size_)
        throw std::out_of_range("CurveList::at");
    return (*this)[i];
}
//<

//> Copy and move a list
CurveList::CurveList(const CurveList &list)
    : size_(list.size_), pointCount_(list.pointCount_), starts_(list.starts_), groups_(list.groups_) {
    if (pointCount_ == 0)
        return;
    points_ = LargePages(PointBytes(pointCount_));
    std::memcpy(points_.Data(), list.points_.Data(), PointBytes(pointCount_));
}
CurveList &CurveList::operator=(CurveList &&list) noexcept {
    std::swap(size_, list.size_);
    std::swap(pointCount_, list.pointCount_);
    std::swap(points_, list.points_);
    starts_.swap(list.starts_);
    groups_.swap(list.groups_);
    return *this;
}
//<

} // namespace cuticle
//<
