// Files: written whole or not at all, read as they are or unpacked; what is damaged is an Error.
#include "files/file.h"

#include "core/error.h"
#include "core/parallel.h"
#include "files/frame_names.h"
#include "files/gzip.h"
#include "files/inputs.h"
#include "message_of.h"

#include <gtest/gtest.h>

#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
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

TEST_F(OutputFileTest, FollowsLinksToWhatIsNotThereYet) {
    fs::create_directory(folder / "far");
    fs::create_symlink("second.txt", folder / "first.txt");
    fs::create_symlink("far/away.txt", folder / "second.txt");
    WriteFileAtomically(Path("first.txt"), "text");
    EXPECT_TRUE(fs::is_symlink(folder / "first.txt"));
    EXPECT_TRUE(fs::is_symlink(folder / "second.txt"));
    EXPECT_EQ(Bytes(Path("far/away.txt")), "text");
    fs::create_symlink("round.txt", folder / "round.txt");
    EXPECT_NE(MessageOf([&] { WriteFileAtomically(Path("round.txt"), "x"); }).find("symbolic links"),
              std::string::npos);
    fs::create_symlink("nowhere/a.txt", folder / "lost.txt");
    EXPECT_NE(MessageOf([&] { WriteFileAtomically(Path("lost.txt"), "x"); }).find("No such file"),
              std::string::npos);
}

TEST_F(OutputFileTest, RespectsWhatIsForbidden) {
    WriteFileAtomically(Path("a.txt"), "kept");
    ::chmod(Path("a.txt").c_str(), 0444); // root could write to it all the same
    EXPECT_NE(MessageOf([&] { WriteFileAtomically(Path("a.txt"), "x"); }).find("Permission denied"),
              std::string::npos);
    EXPECT_EQ(Bytes(Path("a.txt")), "kept");
    EXPECT_NE(MessageOf([&] { OutputFile file(Path(std::string(300, 'a'))); }).find("File name too long"),
              std::string::npos);
    WriteFileAtomically(Path(std::string(255, 'b')), "long"); // the longest name that can be
    EXPECT_EQ(Bytes(Path(std::string(255, 'b'))), "long");
    EXPECT_EQ(FilesInFolder(), 2u);
    // A pipe that nobody reads; one that is read is written to
    ASSERT_EQ(::mkfifo(Path("pipe").c_str(), 0600), 0);
    EXPECT_NE(MessageOf([&] { OutputFile file(Path("pipe")); }).find("a pipe that nobody reads"),
              std::string::npos);
    const File reader(::open(Path("pipe").c_str(), O_RDONLY | O_NONBLOCK));
    WriteFileAtomically(Path("pipe"), "flows");
    char got[5] = {};
    EXPECT_EQ(::read(reader.fd, got, 5), 5);
    EXPECT_EQ(std::string_view(got, 5), "flows");
    // Before anything is written
    EXPECT_NE(MessageOf([&] { OutputFile file("/dev/full"); }).find("No space left"), std::string::npos);
}

TEST_F(OutputFileTest, RoomIsSetAsideAndGivenBack) {
    OutputFile file(Path("a.txt"));
    file.Reserve(1 << 20);
    file.Write("few");
    file.Commit(true);
    EXPECT_EQ(Bytes(Path("a.txt")), "few");
    struct stat status {};
    ASSERT_EQ(::stat(Path("a.txt").c_str(), &status), 0);
    EXPECT_LT(status.st_blocks * 512, 1 << 16);
    struct statvfs disk {};
    ASSERT_EQ(::statvfs(folder.c_str(), &disk), 0);
    OutputFile tooMuch(Path("b.txt"));
    const uint64_t all = disk.f_blocks * disk.f_frsize;
    const File probe(::open(Path("probe").c_str(), O_CREAT | O_WRONLY, 0600));
    if (::fallocate(probe.fd, FALLOC_FL_KEEP_SIZE, 0, 4096) == 0) {
        EXPECT_NE(MessageOf([&] { tooMuch.Reserve(all); }).find("there is no room for it"),
                  std::string::npos);
    }
}

// A child is killed while it writes: its file is known by the lock that nobody holds, and removed; that of
// a writer who lives stays.
TEST_F(OutputFileTest, RemovesWhatKilledRunsLeft) {
    OutputFile living(Path("living.txt"));
    living.Write("some");
    const pid_t child = ::fork();
    if (child == 0) {
        OutputFile *const killed = new OutputFile(Path("killed.txt"));
        killed->Write("half of it");
        ::raise(SIGKILL);
    }
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    Write("notes.cuticle-old", "a user's own file");
    EXPECT_EQ(FilesInFolder(), 3u);
    WriteFileAtomically(Path("next.txt"), "text");
    EXPECT_EQ(FilesInFolder(), 3u) << "living, notes, next";
    living.Commit();
    EXPECT_EQ(Bytes(Path("living.txt")), "some");
    EXPECT_EQ(FilesInFolder(), 3u);
}

TEST_F(OutputFileTest, NothingReadIsOverwritten) {
    InputLog inputs;
    const InputScope scope(&inputs);
    const std::string name = Write("texture.png", "pixels");
    fs::create_symlink("texture.png", folder / "link.png");
    fs::create_hard_link(name, Path("hard.png"));
    ParallelFor(2, [&](size_t) { ReadFile(name, "it"); }); // threads that help note it, too
    for (const char *other : {"texture.png", "link.png", "hard.png", "../"})
        EXPECT_NE(MessageOf([&] { OutputFile file(Path(other)); }), "") << other;
    EXPECT_NE(
        MessageOf([&] { OutputFile file(Path("link.png")); }).find("cannot overwrite what is read here"),
        std::string::npos);
    WriteFileAtomically(Path("other.png"), "x");
    EXPECT_EQ(Bytes(name), "pixels");
    {
        const InputScope nobody(nullptr);
        WriteFileAtomically(name, "new");
    }
    EXPECT_EQ(Bytes(name), "new");
}

class InputLogTest : public FileTest {};

TEST_F(InputLogTest, TheDigestIsOfNamesAndContents) {
    fs::create_directory(folder / "here");
    fs::create_directory(folder / "there");
    const auto digest = [&](const std::string &in, const std::string &a, const std::string &b) {
        const std::string first = Write(in + "/a", a), second = Write(in + "/b", b);
        InputLog log;
        const InputScope scope(&log);
        ReadFile(first, "it");
        ReadFile(second, "it");
        return log.Digest(Path(in));
    };
    // Two pieces, which are read apart
    const std::string big = std::string((16 << 20) + 5, 'x'), one = digest("here", "1", big);
    EXPECT_EQ(one.size(), 32u);
    EXPECT_EQ(digest("there", "1", big), one) << "a scene that was moved is the same";
    std::string other = big;
    other.back() = 'y';
    EXPECT_NE(digest("here", "1", other), one);
    EXPECT_NE(digest("here", "1", big + '\0'), one);
    EXPECT_NE(digest("here", "2", "1"), digest("here", "1", "2")) << "contents that changed places";

    InputLog log;
    const InputScope scope(&log);
    const std::string name = Write("here/c", "before");
    ReadFile(name, "it");
    Write("here/c", "behind that");
    EXPECT_NE(MessageOf([&] { log.Digest(Path("here")); }).find("was changed while"), std::string::npos);
}

TEST(ContentHash, DependsOnBytesAndNotOnTheirPieces) {
    const std::string text = SomeText(1000);
    ContentHash whole;
    whole.Add(text);
    for (const size_t n : {1u, 7u, 32u, 100u}) {
        ContentHash pieces;
        for (size_t at = 0; at < text.size(); at += n)
            pieces.Add(std::string_view(text).substr(at, n));
        EXPECT_EQ(pieces.Hex(), whole.Hex()) << n;
    }
    // No two of all texts of up to 70 bytes of one kind, with one other byte at most, are alike
    std::set<std::string> seen;
    size_t texts = 0;
    for (size_t size = 0; size <= 70; ++size)
        for (size_t other = 0; other <= size; ++other, ++texts) {
            std::string t(size, '\0');
            if (other < size)
                t[other] = 1;
            ContentHash hash;
            hash.Add(t);
            seen.insert(hash.Hex());
        }
    EXPECT_EQ(seen.size(), texts);
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

TEST(FrameNames, HaveOnePlace) {
    const auto name = [](const char *pattern, size_t frame) {
        return FrameNames(pattern, "output", "f%d.exr").Of(frame);
    };
    EXPECT_EQ(name("f/%04d.exr", 7), "f/0007.exr");
    EXPECT_EQ(name("f/%04d.exr", 123456), "f/123456.exr");
    EXPECT_EQ(name("%d", 0), "0");
    EXPECT_EQ(name("a%3db", 7), "a  7b");
    EXPECT_EQ(name("100%.%02d", 3), "100%.03") << "a percent sign that no d follows stays";
    for (const char *pattern : {"f.exr", "", "%", "%123d", "%x", "%4"})
        EXPECT_NE(MessageOf([&] { name(pattern, 0); }).find("no place"), std::string::npos) << pattern;
    EXPECT_NE(MessageOf([&] { name("%d/%d", 0); }).find("two places"), std::string::npos);
    EXPECT_EQ(WithFrameNumber("%d/%03d/%s", 5), "5/005/%s");
}

TEST_F(FileTest, FramesThatAreThereAreFoundByTheirNames) {
    for (const char *file :
         {"f07.png", "f12.png", "f103.png", "f7.png", "f013.png", "g08.png", "f09.pngx", "f.png", "f-1.png"})
        Write(file, "x");
    EXPECT_EQ(FrameNames(Path("f%02d.png"), "picture", "f%d.exr").Existing(),
              (std::vector<size_t>{7, 12, 103}));
    EXPECT_EQ(FrameNames(Path("f%d.png"), "picture", "f%d.exr").Existing(),
              (std::vector<size_t>{7, 12, 103}));
    EXPECT_TRUE(FrameNames(Path("no/f%d.png"), "picture", "f%d.exr").Existing().empty());
}
