#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "client/town/mesh.h"
#include "client/town/random.h"

// Single things that stand in streets and squares. `foot` is where they touch the ground; `facing` is the
// direction of their front, a plane vector.
namespace semmap::town {

void BuildStreetLamp(const glm::vec3& foot, const glm::vec2& facing, MeshBuilder* mesh);
void BuildBin(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
void BuildBench(const glm::vec3& foot, const glm::vec2& facing, MeshBuilder* mesh);
void BuildHydrant(const glm::vec3& foot, MeshBuilder* mesh);
void BuildBollard(const glm::vec3& foot, MeshBuilder* mesh);
void BuildPlanter(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
void BuildCabinet(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
void BuildAdColumn(const glm::vec3& foot, Random* random, MeshBuilder* mesh);
void BuildBillboard(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
void BuildBusStop(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
void BuildTrafficSign(const glm::vec3& foot, const glm::vec2& facing, int sign, MeshBuilder* mesh);
void BuildStatue(const glm::vec3& foot, Random* random, MeshBuilder* mesh);
void BuildFountain(const glm::vec3& foot, Random* random, MeshBuilder* mesh);
void BuildParasol(const glm::vec3& foot, Random* random, MeshBuilder* mesh);
// Things that people move: wheeled bins, boxes, bags, cones, a barrier.
void BuildLooseThings(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh);
// The post of a traffic light with its mast arm reaching `reach` metres along `arm`; the signal heads are
// dynamic.
void BuildSignalPost(const glm::vec3& foot, const glm::vec2& arm, float reach, MeshBuilder* mesh);

}  // namespace semmap::town
