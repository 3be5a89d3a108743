// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/synthesis_json.h"
#include "tools/stf/synthesis_sheet.h"

#include "stfLib/base/temporary_folder.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace stf;
using namespace stf::test;

TEST(SynthesisReport, HasTheNamesOfTheContractAndTheValuesMeasured) {
    const RefinedSurface surface = refinedOf(rectangle(16, 16, 32, 32));
    const Synthesis s = synthesized(surface, waves(24));
    const ExemplarMap map = exemplarMap(s);
    const SynthesisQuality q = measure(s, map);
    const nlohmann::json j = nlohmann::json::parse(synthesisJson(s, q));
    for (const char* key : {"neighbourhoodError", "exemplarError", "seamRate", "reuseMax", "reuseEntropy", "ks",
                            "foldOvers", "deltaR", "samples", "seconds"}) {
        EXPECT_TRUE(j.contains(key)) << key;
    }
    EXPECT_EQ(j["samples"], surface.points.size());
    EXPECT_DOUBLE_EQ(j["seamRate"], q.seamRate);
    EXPECT_DOUBLE_EQ(j["neighbourhoodError"], q.neighbourhoodError);
    EXPECT_GT(j["seconds"], 0);
    EXPECT_NE(synthesisText(s, q).find("seams"), std::string::npos);
}

TEST(SynthesisReport, SheetIsWrittenWholeOrNotAtAll) {
    const TemporaryFolder folder;
    const RefinedSurface surface = refinedOf(rectangle(16, 16, 32, 32));
    const Synthesis s = synthesized(surface, waves(24));
    const ExemplarMap map = exemplarMap(s);
    writeSynthesisSheet(surface, s, map, folder.file("sheet.png"));
    EXPECT_GT(std::filesystem::file_size(folder.file("sheet.png")), 1000u);
    EXPECT_THROW(writeSynthesisSheet(surface, s, map, folder.file("none/sheet.png")), Error);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}
