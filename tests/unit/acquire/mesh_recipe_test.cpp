// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_recipe.h"

#include "tests/unit/acquire/meshes.h"

#include <nlohmann/json.hpp>

using namespace stf;
using namespace stf::test;

namespace {

MeshRecipe parsed(const std::string& text) {
    return parseMeshRecipe(text, "r.json", "folder");
}
std::string complaint(const std::string& text) {
    const std::string m = messageOf<Error>([&] { parsed(text); });
    EXPECT_EQ(m.rfind("r.json", 0), 0u) << m;
    return m;
}
std::string withMesh(const std::string& mesh) {
    return R"({"size": 8, "voxel": 1, "meshes": [)" + mesh + "]}";
}

TEST(MeshRecipe, SaysAllOfIt) {
    const MeshRecipe r = parsed(R"({"about": "x", "name": "n", "size": [3, 4, 5], "voxel": [0.1, 0.2, 0.3],
        "matrix": "Marble", "core": {"sigma_a": 0.5, "sigma_s": [1, 2, 3], "g": -0.2, "ior": 1.4}, "top": {"file": "t.obj",
        "fit": true, "translate": [0, 0, -1]}, "table": "m.json", "meshes": [{"file": "a.obj", "part": "p",
        "material": "Skim milk", "priority": -2, "fit": 0.5, "scale": [1, 2, 3], "rotate": [90, 0, 0], "translate": [1, 2, -3],
        "surface": true, "scatter": {"fraction": 0.2, "seed": 9, "scale": [0.5, 2], "turn": "vertical", "depth": [1, 2],
        "apart": true, "gap": 0.1}}, {"shape": "layer", "material": "x", "depth": [0.1, 0.4], "wave": 0.05, "cells": 3}]})");
    EXPECT_EQ(r.size, Vec3i(3, 4, 5));
    EXPECT_EQ(r.voxelMm, Vec3d(0.1, 0.2, 0.3));
    EXPECT_EQ(r.matrix.name, "Marble");
    ASSERT_TRUE(r.core.given);
    EXPECT_EQ(r.core.given->sigmaS, Vec3d(1, 2, 3));
    EXPECT_EQ(r.core.given->sigmaA, Vec3d(0.5));
    EXPECT_EQ(r.top, MeshRecipe::Top::Relief);
    EXPECT_EQ(r.relief.file, "folder/t.obj");
    EXPECT_EQ(r.reliefPlacement.fit, 1);
    EXPECT_EQ(r.materials, "folder/m.json");
    ASSERT_EQ(r.meshes.size(), 2u);
    const MeshEntry& e = r.meshes[0];
    EXPECT_EQ(e.source.part, "p");
    EXPECT_EQ(e.priority, -2);
    EXPECT_EQ(e.placement.fit, 0.5);
    EXPECT_EQ(e.placement.scale, Vec3d(1, 2, 3));
    EXPECT_TRUE(e.surface);
    ASSERT_TRUE(e.scatter && e.scatter->depthMm);
    EXPECT_EQ(e.scatter->fraction, 0.2);
    EXPECT_EQ(e.scatter->turn, MeshScatter::Turn::Vertical);
    EXPECT_EQ(e.scatter->gapMm, 0.1);
    EXPECT_EQ(r.meshes[1].source.shape, MeshSource::Shape::Layer);
    EXPECT_EQ(r.meshes[1].source.cells, 3);
}

TEST(MeshRecipe, MistakesAreNamedWithTheirPlace) {
    const std::pair<std::string, const char*> cases[] = {
        {"{", "is not JSON"},
        {"[]", "is not an object"},
        {R"({"size": 8})", "needs a 'size'"},
        {R"({"size": [8, 8], "voxel": 1})", "'size' is not a number or a list of three"},
        {R"({"size": [8, 8.5, 8], "voxel": 1})", "not whole"},
        {R"({"size": [8, 8, 1e9], "voxel": 1})", "not within 1 to 4096"},
        {R"({"size": 8, "voxel": 0})", "'voxel'"},
        {R"({"size": 8, "voxel": 1, "matrx": "Marble"})", "has no 'matrx'"},
        {R"({"size": 8, "voxel": 1, "matrix": {"sigma_s": -1}})", "'matrix': sigma_s is -1"},
        {R"({"size": 8, "voxel": 1, "top": "round"})", "'top'"},
        {withMesh(R"({"shape": "sphere"})"), "meshes[0]: a shape needs a 'material'"},
        {withMesh(R"({"file": "a", "shape": "sphere", "material": "x"})"), "one of them"},
        {withMesh(R"({"shape": "ball", "material": "x"})"), "'ball' is not known"},
        {withMesh(R"({"file": "a"}, {"file": "b", "scale": [1, 0, 1]})"), "meshes[1]: 'scale'"},
        {withMesh(R"({"file": "a", "fitt": true})"), "meshes[0]: has no 'fitt'"},
        {withMesh(R"({"file": "a", "scatter": {"seed": 1}})"), "'count' or a 'fraction'"},
        {withMesh(R"({"file": "a", "scatter": {"count": 0}})"), "'count'"},
        {withMesh(R"({"file": "a", "scatter": {"count": 2, "scale": [2, 1]}})"), "larger to the smaller"},
        {withMesh(R"({"shape": "layer", "material": "x"})"), "'depth'"},
        {withMesh(R"({"file": "a", "priority": "high"})"), "meshes[0]: 'priority' holds \"high\""},
    };
    for (const auto& [text, part] : cases) {
        const std::string m = complaint(text);
        EXPECT_NE(m.find(part), std::string::npos) << text << "\n" << m;
    }
}

TEST(MeshRecipe, WordsOfTheCommandLineAreARecipesMesh) {
    EXPECT_EQ(
        nlohmann::json::parse(meshWords("dir/a.obj,material=Skim milk,priority=2,fit,scale=1:2:3,translate=0:0:-1.5,"
                                        "part=3,scatter.count=20,scatter.scale=0.5:1,scatter.apart")),
        nlohmann::json::parse(R"({"file": "dir/a.obj", "material": "Skim milk", "priority": 2, "fit": true,
        "scale": [1, 2, 3], "translate": [0, 0, -1.5], "part": "3",
        "scatter": {"count": 20, "scale": [0.5, 1], "apart": true}})"));
    EXPECT_EQ(nlohmann::json::parse(meshWords("shape=box,material=none")),
              nlohmann::json::parse(R"({"shape": "box", "material": "none"})"));
    EXPECT_THROW(meshWords("a.obj,=3"), Error);
}

TEST(MeshRecipe, WhatDoesNotGoTogetherIsRefused) {
    const std::string head = R"({"size": 8, "voxel": 1, )";
    const std::pair<std::string, const char*> cases[] = {
        {head + R"("matrix": "none", "top": {"shape": "box"}})", "relief needs a matrix"},
        {head + R"("matrix": "Marble", "top": "geometry"})", "'body'"},
        {head + R"("matrix": "Marble", "meshes": [{"shape": "box", "material": "Marble", "body": true}]})", "geometry"},
        {head + R"("matrix": "Marbel"})", "Marble"},
        {head + R"("meshes": [{"shape": "box", "material": "none"}]})", "no material"},
        {R"({"size": 4000, "voxel": 1, "matrix": "Marble"})", "MB"},
        {head + R"("matrix": "Marble", "meshes": [{"file": "z", "material": "Marble"}]})", "no such file"},
        {head + R"("matrix": "Marble", "meshes": [{"shape": "box", "material": "Marble", "scale": 900000}]})", "tiles"},
    };
    for (const auto& [text, part] : cases) {
        const std::string m = messageOf<Error>([&, t = text] { acquired(t); });
        EXPECT_NE(m.find(part), std::string::npos) << text << "\n" << m;
    }
}

TEST(MeshRecipe, WhatAnArtistMayNotHaveMeantIsSaid) {
    const Acquired a = acquired(R"({"size": 8, "voxel": 1, "matrix": "Marble", "meshes": [
        {"shape": "box", "material": "Ketchup", "translate": [0, 0, 4]},
        {"shape": "box", "material": "Ketchup", "scale": 0.01, "translate": [0, 0, -4]}]})");
    ASSERT_EQ(a.messages.size(), 2u);
    EXPECT_NE(a.messages[0].find("above the tile"), std::string::npos) << a.messages[0];
    EXPECT_NE(a.messages[1].find("smaller than a voxel"), std::string::npos) << a.messages[1];
}

} // namespace
