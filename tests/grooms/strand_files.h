// The tests of the readers share this: a folder for files, bytes, messages, and the real models where they
// are at hand.
#pragma once

#include "message_of.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>

namespace cuticle {

// A fresh folder that goes away with the test.
class StrandFiles : public ::testing::Test {
  protected:
    void SetUp() override {
        FlushWarnings();
        std::string pattern = (std::filesystem::temp_directory_path() / "cuticle-hair-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override {
        FlushWarnings();
        std::filesystem::remove_all(folder_);
    }
    std::string Path(const std::string &name) const { return (folder_ / name).string(); }
    std::string Write(const std::string &name, const std::string &bytes) const {
        std::ofstream(Path(name), std::ios::binary) << bytes;
        return Path(name);
    }
    std::filesystem::path folder_;
};

template <typename T>
void Put(std::string *out, const T &v) {
    out->append(reinterpret_cast<const char *>(&v), sizeof v);
}

// A real model, where it is at hand; else says so.
inline std::optional<std::string> RealModel(const std::string &name) {
    const char *shared = std::getenv("CUTICLE_SHARED_DATA");
    const std::filesystem::path file =
        (shared != nullptr ? std::filesystem::path(shared)
                           : std::filesystem::path(CUTICLE_SOURCE_DIR) / "../shared/data") /
        "hair" / name;
    if (std::filesystem::exists(file))
        return file.string();
    std::cout << name << " is not at hand (set CUTICLE_SHARED_DATA); nothing was read\n";
    return {};
}

} // namespace cuticle
