// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_reader.h"

#include "stfLib/acquire/mesh_off.h"
#include "stfLib/acquire/mesh_ply.h"
#include "stfLib/base/error.h"

#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <cctype>
#include <filesystem>

namespace stf {

namespace {

std::string endingOf(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    for (char& c : ending) {
        c = char(std::tolower(static_cast<unsigned char>(c)));
    }
    return ending;
}

Transform transformOf(const aiMatrix4x4& m) {
    Transform t;
    t.x = {double(m.a1), double(m.b1), double(m.c1)};
    t.y = {double(m.a2), double(m.b2), double(m.c2)};
    t.z = {double(m.a3), double(m.b3), double(m.c3)};
    t.translation = {double(m.a4), double(m.b4), double(m.c4)};
    return t;
}

MeshPart partOf(const aiMesh& mesh, const aiNode& node, const aiScene& scene, const Transform& toWorld) {
    MeshPart part;
    part.name = mesh.mName.length ? mesh.mName.C_Str() : node.mName.C_Str();
    if (mesh.mMaterialIndex < scene.mNumMaterials) {
        const std::string name = scene.mMaterials[mesh.mMaterialIndex]->GetName().C_Str();
        // What assimp calls a material that no file named.
        part.material = name == "DefaultMaterial" ? "" : name;
    }
    part.mesh.points.reserve(mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const aiVector3D& p = mesh.mVertices[i];
        part.mesh.points.push_back(toWorld.point({double(p.x), double(p.y), double(p.z)}));
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& f = mesh.mFaces[i];
        if (f.mNumIndices == 3) {
            part.mesh.triangles.push_back({int(f.mIndices[0]), int(f.mIndices[1]), int(f.mIndices[2])});
        }
    }
    return part;
}

void collect(const aiNode& node, const aiScene& scene, const Transform& parent, std::vector<MeshPart>& parts) {
    const Transform toWorld = compose(parent, transformOf(node.mTransformation));
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
        MeshPart part = partOf(*scene.mMeshes[node.mMeshes[i]], node, scene, toWorld);
        if (!part.mesh.triangles.empty()) {
            parts.push_back(std::move(part));
        }
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
        collect(*node.mChildren[i], scene, toWorld, parts);
    }
}

} // namespace

bool isUsdPath(const std::string& path) {
    const std::string e = endingOf(path);
    return e == ".usd" || e == ".usda" || e == ".usdc" || e == ".usdz";
}

std::vector<MeshPart> readMeshFile(const std::string& path, double maxBytes) {
    const std::string ending = endingOf(path);
    if (ending != ".obj" && ending != ".ply" && ending != ".stl" && ending != ".off") {
        throw Error(path + ": its ending is not one of a mesh (obj, ply, stl, off" +
                    (isUsdPath(path) ? "); USD files need a build with OpenUSD" : ", or usd, usda, usdc, usdz)"));
    }
    std::error_code problem;
    if (!std::filesystem::is_regular_file(path, problem)) {
        throw Error(path + ": no such file");
    }
    const double bytes = double(std::filesystem::file_size(path, problem));
    if (problem || bytes > maxBytes) {
        throw Error(path + ": is a file of " + std::to_string(std::int64_t(bytes / 1e6)) + " MB, at most " +
                    std::to_string(std::int64_t(maxBytes / 1e6)) + " MB are read");
    }
    // assimp's readers of these two do not see that a file is cut off, or never come back from it.
    if (ending == ".ply" || ending == ".off") {
        MeshPart part;
        part.name = std::filesystem::path(path).stem().string();
        part.mesh = ending == ".ply" ? readPly(path) : readOff(path);
        return {part};
    }
    std::vector<MeshPart> parts;
    try {
        Assimp::Importer importer;
        const aiScene* const scene = importer.ReadFile(path, aiProcess_Triangulate);
        if (!scene || !scene->mRootNode) {
            std::string why = importer.GetErrorString();
            std::replace(why.begin(), why.end(), '\n', ' ');
            throw Error(path + ": is not a readable mesh (" + why + ")");
        }
        collect(*scene->mRootNode, *scene, Transform(), parts);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        throw Error(path + ": is not a readable mesh (" + e.what() + ")");
    }
    if (parts.empty()) {
        throw Error(path + ": holds no triangle");
    }
    return parts;
}

} // namespace stf
