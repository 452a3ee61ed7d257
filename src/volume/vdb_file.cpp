//> Define how volumes are written for other programs
#include "volume/vdb_file.h"

#include "core/check.h"
#include "core/error.h"
#include "files/file.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <string_view>

namespace cuticle {

namespace {

//> Write numbers, texts and bits as the file has them
// Bytes of the file, little-endian as this machine is.
class VdbBytes {
  public:
    template <typename T>
    void Put(const T &value) {
        bytes_.append(reinterpret_cast<const char *>(&value), sizeof value);
    }
    void PutRaw(std::string_view bytes) { bytes_ += bytes; }
    void PutText(const std::string &text) {
        Put(static_cast<uint32_t>(text.size()));
        bytes_ += text;
    }
    // An entry of a table of texts by name.
    void PutEntry(const std::string &name, const std::string &value) {
        PutText(name);
        PutText("string");
        PutText(value);
    }
    void PutBits(const std::vector<bool> &bits) {
        for (size_t i = 0; i < bits.size(); i += 8) {
            unsigned byte = 0;
            for (size_t k = 0; k < 8; ++k)
                byte |= (bits[i + k] ? 1u : 0u) << k;
            bytes_ += static_cast<char>(byte);
        }
    }
    size_t Size() const { return bytes_.size(); }
    // Writes over what stands at a place.
    void Patch(size_t at, int64_t value) { std::memcpy(&bytes_[at], &value, sizeof value); }
    const std::string &All() const { return bytes_; }

  private:
    std::string bytes_;
};
//<

//> Know the shape of the tree
// The tree has a root, one node of 32^3 nodes of 16^3 leaves of 8^3 voxels: 4,096 to a side. Within a node z
// runs fastest.
constexpr size_t kLeafSide = 8, kInnerSide = 16, kOuterSide = 32;
constexpr uint8_t kAllValues = 6; // of a node: all values follow, none is left out

GridBox::Vertex Offset(size_t index, size_t side) {
    return {index / (side * side), index / side % side, index % side};
}
GridBox::Vertex Inside(const GridBox::Vertex &node, size_t side, const GridBox::Vertex &offset) {
    return {node[0] * side + offset[0], node[1] * side + offset[1], node[2] * side + offset[2]};
}
//<

//> Find which leaves there are
// The leaves that a field has, by their places, and which of their voxels lie in the box and count.
template <typename T>
class SparseLeaves {
  public:
    // background: the value of all that is left out.
    SparseLeaves(const DenseGrid<T> &grid, const T &background, bool keepAll)
        : grid_(grid), background_(background), keepAll_(keepAll) {
        for (size_t axis = 0; axis < 3; ++axis)
            size_[axis] = (grid.box.size[axis] + kLeafSide - 1) / kLeafSide;
        present_.resize(size_[0] * size_[1] * size_[2]);
        for (size_t i = 0; i < present_.size(); ++i) {
            const GridBox::Vertex leaf{i % size_[0], i / size_[0] % size_[1], i / (size_[0] * size_[1])};
            for (size_t k = 0; k < Voxels() && !present_[i]; ++k)
                present_[i] = IsActive(Inside(leaf, kLeafSide, Offset(k, kLeafSide)));
        }
    }
    static constexpr size_t Voxels() { return kLeafSide * kLeafSide * kLeafSide; }
    bool IsPresent(const GridBox::Vertex &leaf) const {
        return leaf[0] < size_[0] && leaf[1] < size_[1] && leaf[2] < size_[2] &&
               present_[(leaf[2] * size_[1] + leaf[1]) * size_[0] + leaf[0]];
    }
    // Whether any leaf of a node of 16^3 leaves is there.
    bool HasAny(const GridBox::Vertex &node) const {
        const GridBox::Vertex first = Inside(node, kInnerSide, {0, 0, 0});
        GridBox::Vertex leaf;
        for (leaf[2] = first[2]; leaf[2] < std::min(size_[2], first[2] + kInnerSide); ++leaf[2])
            for (leaf[1] = first[1]; leaf[1] < std::min(size_[1], first[1] + kInnerSide); ++leaf[1])
                for (leaf[0] = first[0]; leaf[0] < std::min(size_[0], first[0] + kInnerSide); ++leaf[0])
                    if (IsPresent(leaf))
                        return true;
        return false;
    }
    bool IsActive(const GridBox::Vertex &v) const {
        return IsInBox(v) && (keepAll_ || !(grid_.At(v[0], v[1], v[2]) == T{}));
    }
    T Value(const GridBox::Vertex &v) const { return IsInBox(v) ? grid_.At(v[0], v[1], v[2]) : background_; }

  private:
    bool IsInBox(const GridBox::Vertex &v) const {
        return v[0] < grid_.box.size[0] && v[1] < grid_.box.size[1] && v[2] < grid_.box.size[2];
    }
    const DenseGrid<T> &grid_;
    const T background_;
    const bool keepAll_;
    GridBox::Vertex size_{}; // in leaves
    std::vector<bool> present_;
};
//<

//> Write an inner node: which children it has, and values where it has none
template <typename T>
void PutNode(size_t side, const std::function<bool(const GridBox::Vertex &)> &hasChild, VdbBytes *out) {
    std::vector<bool> children(side * side * side);
    for (size_t i = 0; i < children.size(); ++i)
        children[i] = hasChild(Offset(i, side));
    out->PutBits(children);
    out->PutBits(std::vector<bool>(children.size())); // no child is a single active value
    out->Put(kAllValues);
    for (size_t i = 0; i < children.size(); ++i)
        out->Put(T{});
}

// Calls use(node) for the nodes of 16^3 leaves that are there, in the order of the file.
template <typename T>
void ForNodes(const SparseLeaves<T> &leaves, const std::function<void(const GridBox::Vertex &)> &use) {
    for (size_t i = 0; i < kOuterSide * kOuterSide * kOuterSide; ++i)
        if (const GridBox::Vertex node = Offset(i, kOuterSide); leaves.HasAny(node))
            use(node);
}
// Calls use(leaf) for the leaves of a node that are there.
template <typename T>
void ForLeaves(const SparseLeaves<T> &leaves, const GridBox::Vertex &node,
               const std::function<void(const GridBox::Vertex &)> &use) {
    for (size_t i = 0; i < kInnerSide * kInnerSide * kInnerSide; ++i) {
        const GridBox::Vertex leaf = Inside(node, kInnerSide, Offset(i, kInnerSide));
        if (leaves.IsPresent(leaf))
            use(leaf);
    }
}
//<

//> Write a leaf
template <typename T>
void PutLeafMask(const SparseLeaves<T> &leaves, const GridBox::Vertex &leaf, VdbBytes *out) {
    std::vector<bool> active(leaves.Voxels());
    for (size_t i = 0; i < active.size(); ++i)
        active[i] = leaves.IsActive(Inside(leaf, kLeafSide, Offset(i, kLeafSide)));
    out->PutBits(active);
}

template <typename T>
void PutLeafValues(const SparseLeaves<T> &leaves, const GridBox::Vertex &leaf, VdbBytes *out) {
    PutLeafMask(leaves, leaf, out);
    out->Put(kAllValues);
    for (size_t i = 0; i < leaves.Voxels(); ++i)
        out->Put(leaves.Value(Inside(leaf, kLeafSide, Offset(i, kLeafSide))));
}
//<

//> Write the tree: its shape, then its values
// Returns where the values begin.
template <typename T>
size_t PutTree(const DenseGrid<T> &grid, const T &background, bool keepAll, VdbBytes *out) {
    const SparseLeaves<T> leaves(grid, background, keepAll);
    out->Put(int32_t{1}); // one buffer of values
    out->Put(background);
    out->Put(uint32_t{0}); // tiles of the root
    out->Put(uint32_t{1}); // its children: one, at the origin
    for (int axis = 0; axis < 3; ++axis)
        out->Put(int32_t{0});
    PutNode<T>(
        kOuterSide, [&](const GridBox::Vertex &node) { return leaves.HasAny(node); }, out);
    ForNodes<T>(leaves, [&](const GridBox::Vertex &node) {
        PutNode<T>(
            kInnerSide,
            [&](const GridBox::Vertex &leaf) { return leaves.IsPresent(Inside(node, kInnerSide, leaf)); },
            out);
        ForLeaves<T>(leaves, node, [&](const GridBox::Vertex &leaf) { PutLeafMask(leaves, leaf, out); });
    });
    const size_t values = out->Size();
    ForNodes<T>(leaves, [&](const GridBox::Vertex &node) {
        ForLeaves<T>(leaves, node, [&](const GridBox::Vertex &leaf) { PutLeafValues(leaves, leaf, out); });
    });
    return values;
}
//<

//> Write where the lattice lies
// Their map from voxels to the world, with all that OpenVDB computes from it. Vertex (i, j, k) of ours is the
// centre of a voxel.
void PutPlace(const GridBox &box, VdbBytes *out) {
    const double cell = static_cast<double>(box.cell);
    out->PutText("UniformScaleTranslateMap");
    for (size_t axis = 0; axis < 3; ++axis)
        out->Put(static_cast<double>(box.origin[axis]));
    for (const double v : {cell, cell, 1 / cell, 1 / (cell * cell), 0.5 / cell}) // scale, voxel, inverses
        for (size_t axis = 0; axis < 3; ++axis)
            out->Put(v);
}
//<

//> Write a grid, with its places in the file
void PutGrid(const VdbField &field, VdbBytes *out) {
    const auto *numbers = std::get_if<const DenseGrid<float> *>(&field.grid);
    const auto *vectors = std::get_if<const DenseGrid<Vector3f> *>(&field.grid);
    const GridBox &box = numbers ? (*numbers)->box : (*vectors)->box;
    for (const size_t side : box.size)
        CHECK(side >= 1 && side <= kOuterSide * kInnerSide * kLeafSide);
    out->PutText(field.name);
    out->PutText(numbers ? "Tree_float_5_4_3" : "Tree_vec3s_5_4_3");
    out->PutText(""); // no instance of another
    const size_t places = out->Size();
    for (int i = 0; i < 3; ++i)
        out->Put(int64_t{0});
    out->Patch(places, static_cast<int64_t>(out->Size()));
    out->Put(uint32_t{0}); // not compressed
    out->Put(uint32_t{2});
    out->PutEntry("name", field.name);
    out->PutEntry("class", field.kind == VdbField::Kind::Fog        ? "fog volume"
                           : field.kind == VdbField::Kind::Distance ? "level set"
                                                                    : "unknown");
    PutPlace(box, out);
    size_t values;
    if (numbers) {
        const DenseGrid<float> &grid = **numbers;
        // What lies outside of the box is far outside of the hair
        const bool isDistance = field.kind == VdbField::Kind::Distance;
        const float background = isDistance ? *std::max_element(grid.values.begin(), grid.values.end()) : 0;
        values = PutTree(grid, background, isDistance, out);
    } else {
        values = PutTree(**vectors, Vector3f{}, false, out);
    }
    out->Patch(places + 8, static_cast<int64_t>(values));
    out->Patch(places + 16, static_cast<int64_t>(out->Size()));
}
//<

} // namespace

//> Write the file whole or not at all
void WriteVdb(const std::string &filename, const std::vector<VdbField> &fields) {
    OutputFile file(filename); // what cannot be written is said before the work
    VdbBytes out;
    out.Put(int64_t{0x56444220});
    for (const uint32_t version : {224u, 10u, 0u}) // of the format; of a library that writes it
        out.Put(version);
    out.Put(uint8_t{1});                                // grids say where they lie in the file
    out.PutRaw("00000000-0000-4000-8000-000000000000"); // an identity, the same for the same bits
    out.Put(uint32_t{1});
    out.PutEntry("creator", "Cuticle");
    out.Put(static_cast<uint32_t>(fields.size()));
    for (const VdbField &field : fields)
        PutGrid(field, &out);
    file.Write(out.All());
    file.Commit();
}
//<

} // namespace cuticle
//<
