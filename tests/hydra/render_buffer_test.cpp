// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderBuffer.h"

#include "pxr/base/gf/half.h"
#include "pxr/base/gf/vec3i.h"
#include "pxr/base/gf/vec4f.h"

#include <gtest/gtest.h>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

const HdStfWindow whole = {0, 0, 2, 2};

template<class T>
std::vector<T> content(HdStfRenderBuffer& buffer, size_t count) {
    const T* data = static_cast<const T*>(buffer.Map());
    std::vector<T> result(data, data + count);
    buffer.Unmap();
    return result;
}

TEST(RenderBuffer, AMappedImageStaysAsItIs) {
    HdStfRenderBuffer buffer{SdfPath()};
    ASSERT_TRUE(buffer.Allocate(GfVec3i(2, 2, 1), HdFormatFloat32, false));
    buffer.Write(std::vector<float>{1, 2, 3, 4}, 1, whole, {});
    const auto* mapped = static_cast<const float*>(buffer.Map());
    EXPECT_EQ(mapped[3], 4);
    buffer.Write(std::vector<float>{5, 6, 7, 8}, 1, whole, {});
    EXPECT_EQ(mapped[3], 4);
    EXPECT_EQ(buffer.Map(), mapped) << "a second reader sees the same image";
    buffer.Unmap();
    EXPECT_FALSE(buffer.Allocate(GfVec3i(4, 4, 1), HdFormatFloat32, false));
    buffer.Unmap();
    EXPECT_EQ(content<float>(buffer, 4)[3], 8);
}

TEST(RenderBuffer, OtherFormatsAreConverted) {
    HdStfRenderBuffer buffer{SdfPath()};
    const std::vector<float> pixels = {0, 0.5f, 2, 1};
    ASSERT_TRUE(buffer.Allocate(GfVec3i(1, 1, 1), HdFormatUNorm8Vec4, true));
    buffer.Write(pixels, 4, {0, 0, 1, 1}, {});
    EXPECT_EQ(content<uint8_t>(buffer, 4), (std::vector<uint8_t>{0, 128, 255, 255}));
    ASSERT_TRUE(buffer.Allocate(GfVec3i(1, 1, 1), HdFormatFloat16Vec4, true));
    buffer.Write(pixels, 4, {0, 0, 1, 1}, {});
    EXPECT_EQ(content<uint16_t>(buffer, 4)[1], GfHalf(0.5f).bits());
}

TEST(RenderBuffer, WindowsAreCroppedAndSurroundedByTheClearValue) {
    HdStfRenderBuffer buffer{SdfPath()};
    ASSERT_TRUE(buffer.Allocate(GfVec3i(2, 2, 1), HdFormatInt32, false));
    buffer.Write(std::vector<int32_t>{1, 2, 3, 4}, 1, {1, 1, 2, 2}, VtValue(-1));
    EXPECT_EQ(content<int32_t>(buffer, 4), (std::vector<int32_t>{-1, -1, -1, 1}));
}

TEST(RenderBuffer, WhatCannotBeAllocatedIsRefused) {
    HdStfRenderBuffer buffer{SdfPath()};
    EXPECT_FALSE(buffer.Allocate(GfVec3i(2, 2, 2), HdFormatFloat32, false));
    EXPECT_FALSE(buffer.Allocate(GfVec3i(2, 2, 1), HdFormatInvalid, false));
    EXPECT_TRUE(buffer.Allocate(GfVec3i(0, 0, 1), HdFormatFloat32, false));
}

TEST(RenderBuffer, ClearingFillsAllComponents) {
    HdStfRenderBuffer buffer{SdfPath()};
    ASSERT_TRUE(buffer.Allocate(GfVec3i(1, 2, 1), HdFormatFloat32Vec4, false));
    buffer.Clear(VtValue(GfVec4f(1, 2, 3, 4)));
    EXPECT_EQ(content<float>(buffer, 8), (std::vector<float>{1, 2, 3, 4, 1, 2, 3, 4}));
}

} // namespace
