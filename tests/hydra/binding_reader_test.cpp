// SPDX-License-Identifier: Apache-2.0
#include "hdStf/bindingReader.h"

#include "hdStf/messages.h"

#include "pxr/base/gf/vec3d.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/vt/array.h"
#include "pxr/usd/sdf/assetPath.h"

#include <gtest/gtest.h>

#include <limits>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

using Primvars = std::vector<std::pair<TfToken, VtValue>>;

class BindingReader : public testing::Test {
protected:
    std::optional<stf::StfBinding> read(Primvars primvars, bool withVolume = true) {
        if (withVolume) {
            primvars.emplace_back(TfToken("stf:baseVolume"), VtValue(SdfAssetPath("a.vdb", "/x/a.vdb")));
        }
        return HdStfReadBinding(SdfPath("/Prim"), primvars, messages);
    }
    HdStfMessages messages;
};

TEST_F(BindingReader, NothingWithoutAVolume) {
    EXPECT_FALSE(read({{TfToken("stf:thickness"), VtValue(1.0f)}}, false).has_value());
    EXPECT_FALSE(read({{TfToken("stf:baseVolume"), VtValue(SdfAssetPath())}}, false).has_value());
    EXPECT_TRUE(messages.Get().empty());
}

TEST_F(BindingReader, DefaultsAreThoseOfTheSchema) {
    const auto binding = read({});
    ASSERT_TRUE(binding.has_value());
    EXPECT_EQ(binding->baseVolume, "/x/a.vdb");
    EXPECT_EQ(binding->authoredPath, "a.vdb");
    EXPECT_EQ(binding->thickness, 0);
    EXPECT_EQ(binding->scale, 1);
    EXPECT_EQ(binding->mapping, "auto");
    EXPECT_EQ(binding->coreModel, "auto");
    EXPECT_EQ(binding->transport, "") << "as the render setting says";
    EXPECT_FALSE(binding->coreSigmaA.has_value());
}

TEST_F(BindingReader, AMissingFileKeepsItsName) {
    const auto binding = read({{TfToken("stf:baseVolume"), VtValue(SdfAssetPath("gone.vdb"))}}, false);
    ASSERT_TRUE(binding.has_value());
    EXPECT_EQ(binding->authoredPath, "gone.vdb");
    EXPECT_TRUE(binding->baseVolume.empty());
}

TEST_F(BindingReader, ValuesOfNeighbouringTypesAndArraysOfOne) {
    const auto binding = read({{TfToken("stf:thickness"), VtValue(VtDoubleArray{0.5})},
                               {TfToken("stf:scale"), VtValue(2)},
                               {TfToken("stf:mapping"), VtValue(std::string("uv"))},
                               {TfToken("stf:transport"), VtValue(VtTokenArray{TfToken("classic")})},
                               {TfToken("stf:coreSigmaA"), VtValue(GfVec3d(1, 2, 3))},
                               {TfToken("stf:coreSigmaSPrime"), VtValue(VtVec3fArray{{4, 5, 6}})},
                               {TfToken("stf:seed"), VtValue(7)}});
    EXPECT_EQ(binding->thickness, 0.5f);
    EXPECT_EQ(binding->scale, 2);
    EXPECT_EQ(binding->mapping, "uv");
    EXPECT_EQ(binding->transport, "classic");
    EXPECT_EQ(*binding->coreSigmaA, stf::Rgb(1, 2, 3));
    EXPECT_EQ(*binding->coreSigmaSPrime, stf::Rgb(4, 5, 6));
    EXPECT_EQ(binding->seed, 7);
    EXPECT_TRUE(messages.Get().empty());
}

TEST_F(BindingReader, WhatCannotBeReadIsReportedOnceAndTheDefaultStands) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Primvars wrong = {{TfToken("stf:thickness"), VtValue(std::string("thick"))},
                            {TfToken("stf:scale"), VtValue(-1.0f)},
                            {TfToken("stf:mapping"), VtValue(TfToken("sideways"))},
                            {TfToken("stf:coreSigmaA"), VtValue(GfVec3f(nan))},
                            {TfToken("stf:quality"), VtValue(VtFloatArray{1, 2})}};
    for (int i = 0; i < 2; ++i) {
        const auto binding = read(wrong);
        EXPECT_EQ(binding->thickness, 0);
        EXPECT_EQ(binding->scale, 1);
        EXPECT_EQ(binding->mapping, "auto");
        EXPECT_FALSE(binding->coreSigmaA.has_value());
    }
    const auto list = messages.Get();
    ASSERT_EQ(list.size(), wrong.size());
    for (size_t i = 0; i < list.size(); ++i) {
        EXPECT_NE(list[i].text.find("/Prim"), std::string::npos);
        EXPECT_NE(list[i].text.find(wrong[i].first.GetString()), std::string::npos);
    }
}

} // namespace
