// Files: written whole or not at all, read as they are or unpacked; what is damaged is an Error.
#include "files/file.h"

#include "core/error.h"
#include "files/gzip.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace cuticle;
namespace fs = std::filesystem;

namespace {

// A folder of the test's own, gone at its end.
class FileTest : public testing::Test {
  protected:
    FileTest() {
        const auto *info = testing::UnitTest::GetInstance()->current_test_info();
        folder = fs::path(testing::TempDir()) / fmt::format("cuticle_file_{}{}", ::getpid(), info->name());
        fs::create_directories(folder);
    }
    ~FileTest() override { fs::remove_all(folder); }
    std::string Path(const std::string &name) const { return (folder / name).string(); }
    std::string Write(const std::string &name, const std::string &bytes) const {
        std::ofstream(Path(name), std::ios::binary) << bytes;
        return Path(name);
    }
    static std::string Bytes(const std::string &path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    // The bytes of a gzip file that holds text.
    std::string Gzip(const std::string &text) const {
        WriteFileAtomically(Path("packed.gz"), text);
        return Bytes(Path("packed.gz"));
    }
    size_t FilesInFolder() const {
        return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    fs::path folder;
};
class OutputFileTest : public FileTest {};
class GzipTest : public FileTest {};

std::string MessageOf(const std::function<void()> &f) {
    try {
        f();
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

// Everything that a reader gives, asked for in pieces of n bytes.
std::string All(auto &&reader, size_t n) {
    std::string all, piece(n, '\0');
    while (const size_t got = reader.Read(piece.data(), n))
        all.append(piece, 0, got);
    return all;
}

// Text that packs neither well nor badly.
std::string SomeText(size_t words) {
    std::string text;
    uint32_t state = 1;
    for (size_t i = 0; i < words; ++i) {
        state = state * 1664525u + 1013904223u;
        text += fmt::format("{} ", state >> 12);
    }
    return text;
}

} // namespace

TEST_F(OutputFileTest, ReplacesAndKeepsNothingBeside) {
    WriteFileAtomically(Path("a.txt"), "one");
    ::chmod(Path("a.txt").c_str(), 0640);
    WriteFileAtomically(Path("a.txt"), "two");
    EXPECT_EQ(Bytes(Path("a.txt")), "two");
    EXPECT_EQ(FilesInFolder(), 1u);
    EXPECT_EQ(fs::status(Path("a.txt")).permissions(), fs::perms(0640));
    // A link stays one
    fs::create_symlink("a.txt", folder / "link.txt");
    WriteFileAtomically(Path("link.txt"), "three");
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_EQ(Bytes(Path("a.txt")), "three");
}

TEST_F(OutputFileTest, FailuresSayWhyAndLeaveTheOldFile) {
    EXPECT_NE(
        MessageOf([&] { WriteFileAtomically(Path("no/such/a.exr"), "x"); }).find("No such file or directory"),
        std::string::npos);
    EXPECT_NE(MessageOf([&] { WriteFileAtomically(folder.string(), "x"); }).find("Is a directory"),
              std::string::npos);
    EXPECT_NE(MessageOf([&] { WriteFileAtomically("/dev/full", "x"); }).find("No space left on device"),
              std::string::npos);
    EXPECT_TRUE(fs::is_character_file("/dev/full"));

    // A file size limit stands in for a disk that fills up while writing
    WriteFileAtomically(Path("a.txt"), "old");
    struct rlimit before {};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const struct rlimit small { 1000, before.rlim_max };
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &small);
    const std::string message =
        MessageOf([&] { WriteFileAtomically(Path("a.txt"), std::string(5000, 'x')); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    EXPECT_NE(message.find(Path("a.txt")), std::string::npos) << message;
    EXPECT_EQ(Bytes(Path("a.txt")), "old");
    EXPECT_EQ(FilesInFolder(), 1u);
}

TEST_F(GzipTest, ComesBackWhateverThePieces) {
    const std::string text = SomeText(100000), packed = Gzip(text);
    ASSERT_TRUE(IsGzip(packed));
    EXPECT_FALSE(IsGzip(text));
    for (const size_t n : {7u, 4096u, 10000000u})
        EXPECT_EQ(All(GzipReader(packed), n), text) << "read by " << n;
    size_t at = 0;
    GzipReader byBytes([&] { return std::string_view(packed).substr(std::min(at++, packed.size()), 1); });
    EXPECT_EQ(All(byBytes, 1000), text) << "given byte by byte";
    EXPECT_EQ(All(GzipReader(Gzip("")), 10), "");
}

TEST_F(GzipTest, MembersThatFollowOneAnotherAreOne) {
    const std::string a = Gzip("first, "), empty = Gzip(""), b = Gzip("second");
    EXPECT_EQ(All(GzipReader(a + empty + b), 3), "first, second");
}

TEST_F(GzipTest, DamageIsAnError) {
    const std::string packed = Gzip(SomeText(1000));
    for (size_t n = 0; n < packed.size(); n += n < 20 || n + 20 > packed.size() ? 1 : 97)
        EXPECT_NE(MessageOf([&] {
                      All(GzipReader(std::string_view(packed).substr(0, n)), 500);
                  }).find("ends in the middle of its gzip data"),
                  std::string::npos)
            << n << " bytes";
    std::string wrong = packed;
    wrong[wrong.size() - 6] ^= 1; // the check sum
    EXPECT_NE(
        MessageOf([&] { All(GzipReader(wrong), 500); }).find("damaged gzip data (incorrect data check)"),
        std::string::npos);
    EXPECT_NE(MessageOf([&] { All(GzipReader(packed + "behind it"), 500); }).find("damaged gzip data"),
              std::string::npos);
}

// A bomb is refused soon after what anything may grow to, and text that packs well below it is not.
TEST_F(GzipTest, WhatExpandsTooFarIsRefused) {
    const std::string zeros = Gzip(std::string(uint64_t{300} << 20, '\0'));
    GzipReader reader(zeros);
    std::vector<char> to(size_t{1} << 20);
    uint64_t read = 0;
    const std::string message = MessageOf([&] {
        for (size_t n = 1; n > 0; read += n)
            n = reader.Read(to.data(), to.size());
    });
    EXPECT_NE(message.find("unpacks to more than 200 times its size"), std::string::npos) << message;
    EXPECT_GE(read, kFreeExpansion - (uint64_t{1} << 20));
    EXPECT_LE(read, kFreeExpansion + (uint64_t{1} << 20));
    EXPECT_EQ(All(GzipReader(Gzip(std::string(5000000, ' '))), 1 << 20).size(), 5000000u)
        << "a thousandfold, but small";
}

TEST_F(FileTest, InputFileReadsPlainAndPacked) {
    const std::string text = SomeText(200000); // more than its buffer
    for (const size_t n : {1000u, 1u << 20}) {
        EXPECT_EQ(All(InputFile(Write("a.txt", text), "the file"), n), text);
        EXPECT_EQ(All(InputFile(Write("b.txt", Gzip(text)), "the file"), n), text) << "by content, not name";
    }
    EXPECT_EQ(All(InputFile(Write("c.txt", ""), "the file"), 10), "");
    EXPECT_EQ(MessageOf([&] { InputFile("no such", "the file"); }),
              "error: \"no such\": cannot open the file: No such file or directory");
    EXPECT_NE(MessageOf([&] { InputFile("/dev/null", "the file"); }).find("a device or a pipe"),
              std::string::npos);
}
