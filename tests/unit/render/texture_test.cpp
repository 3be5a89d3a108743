// SPDX-License-Identifier: Apache-2.0
// Textures and materials: wrap modes, colour spaces, sharing, what is missing.
#include "stfLib/render/plain_material.h"
#include "stfLib/render/texture.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

using Wrap = TextureMap::Wrap;

// Two pixels beside each other: red 0, then 255.
ImageFile step() {
    ImageFile image;
    image.width = 2;
    image.height = 1;
    image.channels = 4;
    image.bytes = {0, 128, 0, 255, 255, 128, 0, 64};
    return image;
}

TextureMap raw(Wrap wrap) {
    TextureMap map;
    map.wrapS = map.wrapT = wrap;
    map.colorSpace = TextureMap::ColorSpace::Raw;
    return map;
}

/// A file with a picture of 2 x 2 pixels in it: portable pixmap, red, green / blue, white.
class PictureFile {
public:
    explicit PictureFile(const std::string& name) : path_((std::filesystem::temp_directory_path() / name).string()) {
        const unsigned char pixels[] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
        std::ofstream file(path_, std::ios::binary);
        file << "P6 2 2 255\n";
        file.write(reinterpret_cast<const char*>(pixels), sizeof pixels);
    }
    ~PictureFile() { std::filesystem::remove(path_); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

TEST(Texture, WrapModes) {
    const Texture t(step());
    const auto red = [&](float u, Wrap wrap) { return t.at({u, 0.5f}, raw(wrap))[0]; };
    EXPECT_FLOAT_EQ(red(0.25f, Wrap::Repeat), 0);
    EXPECT_FLOAT_EQ(red(0.75f, Wrap::Repeat), 1);
    EXPECT_FLOAT_EQ(red(0.5f, Wrap::Repeat), 0.5f);
    EXPECT_FLOAT_EQ(red(1.25f, Wrap::Repeat), 0);
    EXPECT_FLOAT_EQ(red(-0.25f, Wrap::Repeat), 1);
    EXPECT_FLOAT_EQ(red(1.25f, Wrap::Mirror), 1);
    EXPECT_FLOAT_EQ(red(1.75f, Wrap::Mirror), 0);
    EXPECT_FLOAT_EQ(red(-0.25f, Wrap::Mirror), 0);
    EXPECT_FLOAT_EQ(red(7.0f, Wrap::Clamp), 1);
    EXPECT_FLOAT_EQ(red(-7.0f, Wrap::Clamp), 0);
    EXPECT_FLOAT_EQ(red(1.75f, Wrap::Black), 0);
    EXPECT_FLOAT_EQ(red(std::numeric_limits<float>::infinity(), Wrap::Repeat), 0);
}

TEST(Texture, ColourSpacesLeaveAlphaAlone) {
    const Texture t(step());
    TextureMap map = raw(Wrap::Clamp);
    EXPECT_NEAR(t.at({0.75f, 0.5f}, map)[1], 128.0f / 255, 1e-6f);
    map.colorSpace = TextureMap::ColorSpace::Srgb;
    EXPECT_NEAR(t.at({0.75f, 0.5f}, map)[1], 0.2158605f, 1e-6f); // IEC 61966-2-1 of 128
    EXPECT_NEAR(t.at({0.75f, 0.5f}, map)[3], 64.0f / 255, 1e-6f);
    map.colorSpace = TextureMap::ColorSpace::Auto;
    EXPECT_NEAR(t.at({0.75f, 0.5f}, map)[1], 0.2158605f, 1e-6f);
    ImageFile grey = step();
    grey.channels = 1;
    EXPECT_NEAR(Texture(grey).at({0.75f, 0.5f}, map)[1], 128.0f / 255, 1e-6f);
}

TEST(Texture, TheOriginIsTheLowerLeft) {
    const PictureFile file("stf_texture_origin.ppm");
    TextureStore store;
    const auto t = store.get(file.path());
    EXPECT_EQ(t->at({0.25f, 0.25f}, raw(Wrap::Clamp)), (TextureMap::Rgba{0, 0, 1, 1}));
    EXPECT_EQ(t->at({0.25f, 0.75f}, raw(Wrap::Clamp)), (TextureMap::Rgba{1, 0, 0, 1}));
}

TEST(Texture, StoreSharesAndForgets) {
    const PictureFile file("stf_texture_store.ppm");
    TextureStore store;
    auto a = store.get(file.path());
    EXPECT_EQ(a, store.get(file.path()));
    const std::weak_ptr<const Texture> held = a;
    a.reset();
    EXPECT_TRUE(held.expired());
    EXPECT_THROW(store.get(file.path() + ".none"), Error);
}

TEST(Texture, HugeAndBrokenFilesAreRefused) {
    const std::string path = (std::filesystem::temp_directory_path() / "stf_texture_huge.ppm").string();
    std::ofstream(path) << "P6 30000 30000 255\n";
    EXPECT_THROW(readImageFile(path), Error);
    std::ofstream(path) << "no picture";
    try {
        readImageFile(path);
        FAIL();
    } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    }
    std::filesystem::remove(path);
}

TEST(PlainMaterial, WorkflowsGiveTheirReflectances) {
    TextureStore store;
    PreviewSurface s;
    s.diffuseColor = Rgb(0.8f, 0.4f, 0.2f);
    PreviewPoint p = PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f));
    EXPECT_NEAR(p.f0.x, 0.04f, 1e-6f);
    EXPECT_EQ(p.f90, Rgb(1.0f));
    EXPECT_EQ(p.diffuse, Rgb(0.8f, 0.4f, 0.2f));
    s.metallic = 1.0f;
    p = PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f));
    EXPECT_EQ(p.f0, Rgb(0.8f, 0.4f, 0.2f));
    EXPECT_EQ(p.f90, p.f0);
    EXPECT_EQ(p.diffuse, Rgb(0.0f));
    s.useSpecularWorkflow = true;
    s.specularColor = Rgb(0.3f, 0.2f, 0.1f);
    p = PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f));
    EXPECT_EQ(p.f0, Rgb(0.3f, 0.2f, 0.1f));
    EXPECT_EQ(p.f90, Rgb(1.0f));
    EXPECT_EQ(p.diffuse, Rgb(0.8f, 0.4f, 0.2f));
    s = PreviewSurface();
    s.ior = 1.0f;
    EXPECT_TRUE(PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f)).isLambert());
}

TEST(PlainMaterial, TexturesAreScaledTurnedAndReadByChannel) {
    const PictureFile file("stf_texture_material.ppm");
    TextureStore store;
    PreviewSurface s;
    TextureMap map = raw(Wrap::Clamp);
    map.file = file.path();
    s.diffuseColor.texture = map;
    map.channel = 1;
    map.scale = {1, 0.5f, 1, 1};
    map.bias = {0, 0.125f, 0, 0};
    map.uvRotation = 90; // (0.75, 0.75) reads (-0.75, 0.75) + (1, 0)
    map.uvTranslation = {1, 0};
    s.roughness.texture = map;
    const PlainMaterial m("/m", s, store, {});
    EXPECT_EQ(m.at({0.25f, 0.75f}, Rgb(0.0f)).diffuse, Rgb(1, 0, 0));
    EXPECT_EQ(m.at({0.75f, 0.75f}, Rgb(0.0f)).diffuse, Rgb(0, 1, 0));
    EXPECT_NEAR(m.at({0.75f, 0.75f}, Rgb(0.0f)).roughness, 0.125f, 1e-5f); // red: no green
    EXPECT_NEAR(m.at({0.75f, 0.25f}, Rgb(0.0f)).roughness, 0.625f, 1e-5f); // green
    EXPECT_EQ(m.textures(), 2);
}

TEST(PlainMaterial, AMissingTextureIsNamedAndFallsBack) {
    TextureStore store;
    PreviewSurface s;
    TextureMap map;
    map.authoredPath = "./none.png";
    map.fallback = {0.25f, 0.5f, 0.75f, 1};
    s.diffuseColor.texture = map;
    std::vector<std::string> said;
    const PlainMaterial m("/World/Look", s, store, [&](Severity severity, const std::string& text) {
        EXPECT_EQ(severity, Severity::Error);
        said.push_back(text);
    });
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("/World/Look"), std::string::npos);
    EXPECT_NE(said[0].find("./none.png"), std::string::npos);
    EXPECT_EQ(m.at({0.5f, 0.5f}, Rgb(0.0f)).diffuse, Rgb(0.25f, 0.5f, 0.75f));
}

TEST(PlainMaterial, OpacityIsCutAtItsThreshold) {
    TextureStore store;
    PreviewSurface s;
    EXPECT_TRUE(PlainMaterial("/m", s, store, {}).opaque());
    s.opacity = 0.4f;
    const PlainMaterial clear("/m", s, store, {});
    EXPECT_FALSE(clear.opaque());
    EXPECT_FLOAT_EQ(clear.at({}, Rgb(0.0f)).opacity, 0.4f);
    s.opacityThreshold = 0.5f;
    EXPECT_FLOAT_EQ(PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f)).opacity, 0);
    s.opacityThreshold = 0.3f;
    EXPECT_TRUE(PlainMaterial("/m", s, store, {}).opaque());
    EXPECT_FLOAT_EQ(PlainMaterial("/m", s, store, {}).at({}, Rgb(0.0f)).opacity, 1);
}

} // namespace
} // namespace stf::test
