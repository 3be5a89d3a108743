// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/cache_settings.h"

#include "tests/unit/support/environment.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

TEST(CacheSettings, FolderByTheEnvironment) {
    const Environment own("HDSTF_CACHE_DIR", "/own"), xdg("XDG_CACHE_HOME", "/xdg"), home("HOME", "/home/me");
    EXPECT_EQ(cacheFolder(), "/own");
    const Environment noOwn("HDSTF_CACHE_DIR", "");
    EXPECT_EQ(cacheFolder(), "/xdg/hdstf");
    const Environment noXdg("XDG_CACHE_HOME", nullptr);
    EXPECT_EQ(cacheFolder(), "/home/me/.cache/hdstf");
}

TEST(CacheSettings, LimitByTheEnvironment) {
    struct Case {
        const char* text;
        std::uint64_t bytes;
        bool understood;
    };
    constexpr std::uint64_t kDefault = 4'096'000'000;
    for (const Case& c :
         {Case{nullptr, kDefault, true}, Case{"", kDefault, true}, Case{"1", 1'000'000, true}, Case{"0", 0, true},
          Case{"10000", 10'000'000'000, true}, Case{"-1", kDefault, false}, Case{"lots", kDefault, false},
          Case{"10 MB", kDefault, false}, Case{"1.5", kDefault, false}}) {
        const Environment limit("HDSTF_CACHE_MAX_MB", c.text);
        EXPECT_EQ(cacheLimit().bytes, c.bytes) << (c.text ? c.text : "(none)");
        EXPECT_EQ(cacheLimit().complaint.empty(), c.understood);
        if (!c.understood) {
            EXPECT_NE(cacheLimit().complaint.find(c.text), std::string::npos);
        }
    }
    const Environment huge("HDSTF_CACHE_MAX_MB", "99999999999999999999999");
    EXPECT_GT(cacheLimit().bytes, std::uint64_t(1) << 60);
    EXPECT_TRUE(cacheLimit().complaint.empty());
}

} // namespace
