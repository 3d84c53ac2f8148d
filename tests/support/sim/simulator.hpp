#pragma once
// A small simulator that steps as client/STEPPING.md tells: distances that hold bodies together, discrete contacts that
// push features apart, and advances of a scene that decide how far each step goes. Everything it computes is the same
// on every machine.

#include <memory>

#include "tests/support/case.hpp"

namespace collided::test {

/// Two vertices that are to stay `length` apart.
struct Spring {
  uint32_t a, b;
  double length;
};

/// Bodies, scene-wide: `start` of the case is where they begin; static meshes never move.
struct Bodies {
  Case meshes;
  std::vector<Spring> springs;
  Positions velocity;        ///< of each vertex, a second
  std::vector<double> pull;  ///< of each vertex: its velocity is kept along x, and moves it so for ever; 0: is free
  Vec3d gravity{0, 0, -9.8};
  double time_step = 1.0 / 120;
  double repulsion = 0.01;        ///< distance below which features are pushed apart
  double min_separation = 0.001;  ///< that advances keep
};

/// Springs along all edges, and across each pair of triangles that share one, so that a sheet resists to bend.
void add_springs(Bodies& bodies, uint32_t mesh);
/// Springs between all vertices of a mesh.
void make_stiff(Bodies& bodies, uint32_t mesh);

class Simulator {
 public:
  Simulator(Bodies bodies, Backend backend, Scalar scalar, AdvanceMode mode = AdvanceMode::kAllOrOne);
  ~Simulator();

  struct Step {
    double advanced = 1;      ///< the least fraction that anything went
    double way = 1;           ///< the share of the motion
    double earliest_toi = 1;  ///< of the whole way, without what separates; at least min_separation is kept before it
    uint64_t contacts = 0;    ///< of the whole way
  };
  Step step();

  /// The scene's positions, which are what the format holds.
  const Positions& positions() const { return x_; }
  /// The bodies' case between the positions before the last step and those after it.
  Case last_way() const;
  const Bodies& bodies() const { return bodies_; }

 private:
  Positions wanted() const;
  void hold_together(Positions& p) const;
  void push_apart(Positions& p, const FrameResult& near) const;
  /// How far each vertex went.
  std::vector<double> fractions(const FrameResult& way) const;
  bool is_free(uint32_t vertex) const { return !is_static_[vertex] && bodies_.pull[vertex] == 0; }
  Case case_of(const Positions& start, const Positions& end) const;

  Bodies bodies_;
  Scalar scalar_;
  AdvanceMode mode_;
  Positions x_, before_, v_;
  std::vector<bool> is_static_;
  std::unique_ptr<Detector> near_;     ///< discrete contacts, for repulsion
  std::unique_ptr<Detector> advance_;  ///< continuous, for the step
};

}  // namespace collided::test
