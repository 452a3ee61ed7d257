// One mesh in every dress that PLY has, and files that lie.
#include "shapes/ply.h"
#include "warnings.h"

#include "core/error.h"
#include "core/sampling.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <zlib.h>

namespace cuticle {
namespace {

template <typename T>
void Put(std::string *out, T value, bool big) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big != (std::endian::native == std::endian::big))
        std::reverse(bytes, bytes + sizeof(T));
    out->append(bytes, sizeof(T));
}

// A square as a quad and a triangle above it, with normals, texture coordinates and what a reader has to
// skip.
std::string Ascii() {
    return "ply\r\nformat ascii 1.0\r\ncomment a comment\r\nobj_info something\r\n"
           "element camera 1\nproperty float whatever\nproperty list uchar int many\n"
           "element vertex 5\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
           "property list uchar float weights\nproperty double z\nproperty float x\nproperty float y\n"
           "property float s\nproperty float t\n"
           "element face 2\nproperty int material\nproperty list uint8 int32 vertex_indices\nproperty list "
           "uchar "
           "float texcoord\nelement edge 1\nproperty int a\nend_header\n"
           "3.5 2 1 2\n"
           "0 0 1 255 2 0.5 0.5 0 0 0 0 0\n"
           "0 0 1 0 0 0 1 0 1 0\n"
           "0 0 1 0 0 0 1e0 1 1 1\n"
           "0 0 1 0 1 9 0 +0 1 0 1\n"
           "0 0 1 0 0 2.5 0.5 0.5 .5 .5\n"
           "7 4 0 1 2 3 0\n"
           "7 3 0 1 4 2 0.1 0.2\n"
           "1\n";
}

std::string Binary(bool big) {
    std::string s =
        std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
        " 1.0\nelement vertex 5\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar "
        "red\nproperty list ushort float weights\nproperty double z\nproperty float x\nproperty float y\n"
        "property float texture_u\nproperty float texture_v\n"
        "element face 2\nproperty short material\nproperty list uint ushort vertex_index\nend_header\n";
    const float p[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0.5f, 2.5f}};
    for (const auto &v : p) {
        for (const float n : {0.f, 0.f, 1.f})
            Put(&s, n, big);
        Put(&s, uint8_t{200}, big);
        Put(&s, uint16_t{1}, big);
        Put(&s, 4.f, big);
        Put(&s, static_cast<double>(v[2]), big);
        for (const float f : {v[0], v[1], v[0], v[1]})
            Put(&s, f, big);
    }
    Put(&s, int16_t{-1}, big);
    Put(&s, uint32_t{4}, big);
    for (uint16_t i = 0; i < 4; ++i)
        Put(&s, i, big);
    Put(&s, int16_t{-1}, big);
    Put(&s, uint32_t{3}, big);
    for (const unsigned i : {0u, 1u, 4u})
        Put(&s, static_cast<uint16_t>(i), big);
    return s;
}

void ExpectTheMesh(const TriangleMesh &mesh) {
    const std::vector<Point3f> p = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0.5f, 2.5f}};
    EXPECT_EQ(mesh.p, p);
    ASSERT_EQ(mesh.n.size(), 5u);
    ASSERT_EQ(mesh.uv.size(), 5u);
    for (size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(mesh.n[i], Normal3f(0, 0, 1));
        EXPECT_EQ(mesh.uv[i], Point2f(p[i].x, p[i].y));
    }
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 3, 0, 2, 0, 1, 4}));
}

std::string TempFile(const std::string &name, const std::string &bytes, bool compress) {
    const std::string path = testing::TempDir() + "cuticle_ply_" + name;
    if (compress) {
        gzFile file = gzopen(path.c_str(), "wb");
        gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
        gzclose(file);
    } else {
        std::ofstream(path, std::ios::binary) << bytes;
    }
    return path;
}

TEST(Ply, ReadsEveryFormat) {
    ExpectTheMesh(ReadPlyBytes(Ascii(), "ascii"));
    ExpectTheMesh(ReadPlyBytes(Binary(false), "little"));
    ExpectTheMesh(ReadPlyBytes(Binary(true), "big"));
    for (const bool compress : {false, true}) {
        ExpectTheMesh(ReadPly(TempFile("a.ply", Ascii(), compress)));
        ExpectTheMesh(ReadPly(TempFile("b.ply.gz", Binary(true), compress)));
    }
}

std::string MessageOf(const std::string &bytes) {
    try {
        ReadPlyBytes(bytes, "FILE");
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

// A file that ends anywhere before its last face is an error that names the file.
TEST(Ply, TruncationIsAnErrorAtEveryByte) {
    const std::string ascii = Ascii(), lastAscii = "4 2 0.1";
    const size_t asciiEnd = ascii.rfind(lastAscii);
    for (size_t n = 0; n < asciiEnd; ++n)
        EXPECT_NE(MessageOf(ascii.substr(0, n)).find("FILE"), std::string::npos) << n << " bytes";
    for (const bool big : {false, true}) {
        const std::string binary = Binary(big);
        for (size_t n = 0; n < binary.size(); ++n)
            EXPECT_NE(MessageOf(binary.substr(0, n)).find("FILE"), std::string::npos) << n << " bytes";
    }
    EXPECT_THROW(ReadPly(testing::TempDir() + "cuticle_no_such.ply"), Error);
}

TEST(Ply, TruncatedGzipIsAnError) {
    const std::string path = TempFile("c.ply.gz", Binary(false), true);
    std::ifstream in(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    EXPECT_THROW(ReadPly(TempFile("d.ply.gz", bytes.substr(0, bytes.size() / 2), false)), Error);
}

TEST(Ply, SaysWhatIsWrong) {
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    EXPECT_EQ(MessageOf(head + faces + points + "3 0 1 2\n"), "");
    const struct {
        std::string bytes, says;
    } cases[] = {
        {"solid stl\n", "not a PLY file"},
        {"ply\nelement vertex 3\nend_header\n", "format"},
        {"ply\nformat utf8 1.0\nend_header\n", "utf8"},
        {head + "property quad w\nend_header\n", "quad"},
        {"ply\nformat ascii 1.0\nelement vertex many\n", "many"},
        {"ply\nformat ascii 1.0\nelement vertex -1\n", "-1"},
        {"ply\nformat ascii 1.0\nproperty float x\n", "before the first element"},
        {"ply\nformat ascii 1.0\nnonsense here\n", "nonsense"},
        {"ply\nformat ascii 1.0\n" + std::string(5000, 'x'), "4096"},
        {head + "end_header\n" + points, "no faces"},
        {"ply\nformat ascii 1.0\n" + faces + "3 0 1 2\n", "no vertices"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
         "x, y or z"},
        {head + "element face 1\nproperty int a\nend_header\n" + points + "1\n", "vertex_indices"},
        {head + "element face 1\nproperty list float int vertex_indices\n", "float"},
        {head + faces + points + "3 0 1 3\n", "index 3"},
        {head + faces + points + "3 0 1 -1\n", "-1"},
        {head + faces + points + "3 0 1 1.5\n", "1.5"},
        {head + faces + points + "-3 0 1 1\n", "length -3"},
        {head + faces + points + "3 0 one 1\n", "\"one\""},
        {head + faces + "0 0 zero" + points, "\"zero0\""},
        {head + faces + points + "3 0 1 " + std::string(100, '1'), "64"},
    };
    for (const auto &c : cases)
        EXPECT_NE(MessageOf(c.bytes).find(c.says), std::string::npos)
            << "expected \"" << c.says << "\" in \"" << MessageOf(c.bytes) << "\"";
}

// Counts that no file can hold are found out by what the file holds, without memory for what it claims.
TEST(Ply, AbsurdCountsCostNothing) {
    for (const std::string count : {"4000000000", "18446744073709551615"}) {
        const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex " + count +
                                 "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                                 count + "\nproperty list uint uint vertex_indices\nend_header\n";
        EXPECT_NE(MessageOf(head + std::string(100, '\0')), "");
    }
    const std::string lists =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uint uint vertex_indices\nend_header\n";
    EXPECT_NE(MessageOf(lists + std::string(12, '\0') + "\xff\xff\xff\xff" + std::string(40, '\0')), "");
    // An element without properties has no bytes, however many there are.
    EXPECT_NE(MessageOf("ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n"), "");
}

// Numbers beyond the range of a double: the small ones are 0, the large ones infinite (and for SolidSet to
// drop).
TEST(Ply, NumbersBeyondADouble) {
    const TriangleMesh mesh = ReadPlyBytes(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "1e-400 -1E-999 1e-60\n1e400 -1e400 +1\n0 1 0\n3 0 1 2\n",
        "range");
    EXPECT_EQ(mesh.p[0], Point3f(0, 0, 0));
    EXPECT_EQ(mesh.p[1], Point3f(Infinity, -Infinity, 1));
}

TEST(Ply, FacesOfTwoCornersAreDroppedAndPolygonsFan) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n2 0 1\n5 0 1 2 3 4\n0\n";
    const TriangleMesh mesh = ReadPlyBytes(text, "fan");
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 3, 0, 2, 4, 0, 3}));
    EXPECT_TRUE(mesh.n.empty() && mesh.uv.empty());
    EXPECT_EQ(FlushWarnings(), 1u);
}

// Bytes changed at random: an Error or a mesh whose indices are good, never anything else.
TEST(Ply, SurvivesRandomDamage) {
    RNG rng(77);
    int read = 0, refused = 0;
    const std::string files[] = {Ascii(), Binary(false), Binary(true)};
    for (int i = 0; i < 30000; ++i) {
        std::string bytes = files[i % 3];
        for (uint32_t k = 1 + rng.UniformUInt32() % 4; k > 0; --k)
            bytes[rng.UniformUInt32() % bytes.size()] = static_cast<char>(rng.UniformUInt32());
        try {
            const TriangleMesh mesh = ReadPlyBytes(bytes, "damaged");
            for (const uint32_t index : mesh.indices)
                ASSERT_LT(index, mesh.p.size());
            ASSERT_EQ(mesh.indices.size() % 3, 0u);
            ++read;
        } catch (const Error &) {
            ++refused;
        }
    }
    FlushWarnings();
    EXPECT_GT(read, 1000);
    EXPECT_GT(refused, 1000);
}

} // namespace
} // namespace cuticle
