#include "server/reading/packed_motion.h"

#include <utility>

#include "server/reading/packed_contacts.h"
#include "server/reading/packed_parts.h"

namespace handgraft::server {

namespace {

void put(ByteWriter& out, const Pose& X) {
  const Eigen::Matrix<double, 3, 4> rows = X.matrix().topRows<3>();
  out.numbers(rows.data(), 12);
}

Pose takeRows(ByteReader& in) {
  Eigen::Matrix<double, 3, 4> rows;
  in.numbers(rows.data(), 12);
  Pose X = Pose::Identity();
  X.matrix().topRows<3>() = rows;
  return X;
}

}  // namespace

void put(ByteWriter& out, const manipulation::Motion& motion) {
  out.text(motion.name);
  out.text(motion.object);
  put(out, motion.side);
  out.text(motion.hand);
  out.count(motion.time_s.size());
  out.numbers(motion.time_s.data(), motion.time_s.size());
  for (const Pose& X : motion.X_WO)
    put(out, X);
  out.count(motion.tracks.size());
  for (const manipulation::PatchTrack& track : motion.tracks) {
    out.text(track.name);
    out.number(static_cast<std::int32_t>(track.end));
    out.count(track.keys.size());
    for (const manipulation::PatchKey& key : track.keys) {
      out.number(static_cast<std::int32_t>(key.frame));
      put(out, key.patch);
      out.count(key.hand_points.size());
      for (const manipulation::HandPoint& point : key.hand_points) {
        out.text(point.link);
        out.numbers(point.p_L.data(), 3);
      }
    }
  }
  out.count(motion.demonstrator.size());
  for (const manipulation::DemonstratorKey& key : motion.demonstrator) {
    out.number(static_cast<std::int32_t>(key.frame));
    put(out, key.X_OD);
    put(out, key.posture);
  }
  put(out, motion.notes);
}

manipulation::Motion takeMotion(ByteReader& in, const geometry::TriangleMesh& mesh_O) {
  manipulation::Motion motion;
  motion.name = in.text();
  motion.object = in.text();
  motion.side = takeSide(in);
  motion.hand = in.text();
  motion.time_s.resize(in.count(manipulation::kMostFrames, 13 * sizeof(double)));
  in.numbers(motion.time_s.data(), motion.time_s.size());
  for (std::size_t k = 0; k < motion.time_s.size(); ++k)
    motion.X_WO.push_back(takeRows(in));
  motion.tracks.resize(in.count(manipulation::kMostKeys, 2 * kCountSize));
  for (manipulation::PatchTrack& track : motion.tracks) {
    track.name = in.text();
    track.end = in.number<std::int32_t>();
    track.keys.resize(in.count(manipulation::kMostKeys, 4 * kCountSize));
    for (manipulation::PatchKey& key : track.keys) {
      key.frame = in.number<std::int32_t>();
      in.require(key.frame >= 0, "a key before the first frame");
      key.patch = takePatch(in);
      key.hand_points.resize(in.count(contact::kMostPoints, 4 * sizeof(double)));
      for (manipulation::HandPoint& point : key.hand_points) {
        point.link = in.text();
        point.p_L = in.point();
      }
    }
  }
  if (in.form() > 2) {
    motion.demonstrator.resize(in.count(manipulation::kMostFrames, 13 * sizeof(double)));
    for (manipulation::DemonstratorKey& key : motion.demonstrator) {
      key.frame = in.number<std::int32_t>();
      key.X_OD = takeRows(in);
      key.posture = takePosture(in);
    }
  }
  motion.notes = takeTexts(in);
  manipulation::validate(mesh_O, motion);
  return motion;
}

}  // namespace handgraft::server
