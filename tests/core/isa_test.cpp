#include "core/isa.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace cuticle {
namespace {

// Sets CUTICLE_ISA while it lives.
class IsaInEnvironment {
  public:
    explicit IsaInEnvironment(const char *value) {
        if (const char *before = std::getenv("CUTICLE_ISA"))
            before_ = before, wasSet_ = true;
        if (value)
            setenv("CUTICLE_ISA", value, 1);
        else
            unsetenv("CUTICLE_ISA");
    }
    ~IsaInEnvironment() {
        if (wasSet_)
            setenv("CUTICLE_ISA", before_.c_str(), 1);
        else
            unsetenv("CUTICLE_ISA");
    }

  private:
    std::string before_;
    bool wasSet_ = false;
};

std::string MessageOf(const std::string &option) {
    try {
        ChooseIsa(option);
    } catch (const Error &error) {
        return error.Message();
    }
    return "no error";
}

TEST(Isa, TheWidestThatRunsIsTheDefault) {
    const IsaInEnvironment none(nullptr);
    const std::vector<InstructionSet> supported = SupportedIsas();
    ASSERT_FALSE(supported.empty());
    EXPECT_EQ(ChooseIsa(), supported.front());
    EXPECT_EQ(supported.back(), InstructionSet::Sse2);
    EXPECT_TRUE(std::is_sorted(supported.rbegin(), supported.rend()));
}

TEST(Isa, TheEnvironmentChooses) {
    for (const InstructionSet isa : {InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512}) {
        const IsaInEnvironment named(IsaName(isa));
        const std::vector<InstructionSet> supported = SupportedIsas();
        if (std::find(supported.begin(), supported.end(), isa) != supported.end())
            EXPECT_EQ(ChooseIsa(), isa);
        else
            EXPECT_THROW(ChooseIsa(), Error);
    }
}

TEST(Isa, AnOptionComesBeforeTheEnvironment) {
    const IsaInEnvironment wrong("mmx");
    EXPECT_EQ(ChooseIsa("sse2"), InstructionSet::Sse2);
}

TEST(Isa, AnUnknownNameSaysWhereItStandsAndWhatIsKnown) {
    const IsaInEnvironment wrong("sse3");
    EXPECT_EQ(MessageOf(""),
              "unknown instruction set \"sse3\" in the environment's CUTICLE_ISA. Known are: sse2, "
              "avx2, avx512.");
    EXPECT_EQ(MessageOf("mmx"),
              "unknown instruction set \"mmx\" in the option isa. Known are: sse2, avx2, avx512.");
}

} // namespace
} // namespace cuticle
