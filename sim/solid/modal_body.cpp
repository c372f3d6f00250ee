#include "sim/solid/modal_body.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <stdexcept>

#include "sim/solid/cell_batches.h"

namespace powbench::sim {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Gradients of the shape functions and, of hexahedra, the hourglass vectors gamma_h with their stiffness.
struct CellOperators {
  double volume = 0;
  std::vector<Vec3> gradient;  ///< 1/m, by corner
  std::array<std::array<double, 8>, 4> gamma{};
  std::array<double, 12> stiffness{};
};

CellOperators operators_of(const SolidMesh& mesh, const SolidCell& cell, const SolidMaterial& material) {
  CellOperators op;
  std::array<Vec3, 8> x{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(cell.corners()); ++a)
    x[a] = mesh.nodes[static_cast<std::size_t>(cell.nodes[a])];
  op.volume = cell_volume(mesh, cell);
  if (!cell.is_hex()) {
    const double six = 6 * op.volume;
    op.gradient = {{},
                   1 / six * cross(x[2] - x[0], x[3] - x[0]),
                   1 / six * cross(x[3] - x[0], x[1] - x[0]),
                   1 / six * cross(x[1] - x[0], x[2] - x[0])};
    op.gradient[0] = -(op.gradient[1] + op.gradient[2] + op.gradient[3]);
    return op;
  }
  const HexShape s = hex_shape(x);
  for (const Vec3& b : hex_gradient(s)) op.gradient.push_back(1 / op.volume * b);
  op.stiffness = hourglass_stiffness(s, material);
  for (std::size_t h = 0; h < 4; ++h)
    for (std::size_t a = 0; a < 8; ++a)
      op.gamma[h][a] =
          hex_sign(static_cast<int>(3 + h), static_cast<int>(a)) - dot(s.hourglass[h], op.gradient[a]);
  return op;
}

/// K of small displacements; row and column 3 node + axis.
Sparse stiffness(const SolidMesh& mesh, const SolidMaterial& material) {
  std::vector<Eigen::Triplet<double>> entries;
  const double lambda = material.lambda(), mu = material.mu();
  for (const SolidCell& cell : mesh.cells) {
    const CellOperators op = operators_of(mesh, cell, material);
    for (std::size_t a = 0; a < op.gradient.size(); ++a)
      for (std::size_t b = 0; b < op.gradient.size(); ++b)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            const Vec3 &ga = op.gradient[a], &gb = op.gradient[b];
            double k = op.volume * (lambda * ga[i] * gb[j] + mu * ga[j] * gb[i]);
            if (i == j) {
              k += op.volume * mu * dot(ga, gb);
              for (std::size_t h = 0; cell.is_hex() && h < 4; ++h)
                k += op.stiffness[3 * h + static_cast<std::size_t>(i)] * op.gamma[h][a] * op.gamma[h][b];
            }
            entries.emplace_back(3 * cell.nodes[a] + i, 3 * cell.nodes[b] + j, k);
          }
  }
  const auto size = static_cast<Eigen::Index>(3 * mesh.nodes.size());
  Sparse k(size, size);
  k.setFromTriplets(entries.begin(), entries.end());
  return k;
}

/// Makes the columns orthonormal in the masses, twice, leaving out what the first `kept` already span.
Matrix orthonormal(const Matrix& columns, const Vector& mass) {
  Matrix q(columns.rows(), 0);
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    Vector v = columns.col(c);
    const double before = std::sqrt(v.dot(mass.cwiseProduct(v)));
    for (int twice = 0; twice < 2; ++twice)
      if (q.cols() > 0) v -= q * (q.transpose() * mass.cwiseProduct(v));
    const double after = std::sqrt(v.dot(mass.cwiseProduct(v)));
    if (!(after > 1e-9 * before)) continue;
    q.conservativeResize(Eigen::NoChange, q.cols() + 1);
    q.col(q.cols() - 1) = v / after;
  }
  return q;
}

Matrix rigid_modes(const SolidMesh& mesh, const Vector& mass) {
  Vec3 centre;
  double total = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    centre += mass[static_cast<Eigen::Index>(3 * n)] * mesh.nodes[n];
    total += mass[static_cast<Eigen::Index>(3 * n)];
  }
  centre = 1 / total * centre;
  Matrix r = Matrix::Zero(mass.size(), 6);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (int k = 0; k < 3; ++k) {
      Vec3 axis;
      axis[k] = 1;
      const Vec3 turn = cross(axis, mesh.nodes[n] - centre);
      for (int i = 0; i < 3; ++i) {
        r(static_cast<Eigen::Index>(3 * n) + i, k) = axis[i];
        r(static_cast<Eigen::Index>(3 * n) + i, 3 + k) = turn[i];
      }
    }
  return orthonormal(r, mass);
}

/// Ritz vectors and values of K on an M-orthonormal basis.
Vector ritz(const Sparse& k, Matrix& basis) {
  if (basis.cols() == 0) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> small(basis.transpose() * (k * basis));
  basis = (basis * small.eigenvectors()).eval();
  return small.eigenvalues();
}

void remove(const Matrix& rigid, const Vector& mass, Matrix& from) {
  from -= rigid * (rigid.transpose() * (mass.asDiagonal() * from));
}

}  // namespace

ModalBody reduce(const SolidMesh& mesh, const SolidMaterial& material, int modes,
                 const std::vector<Attachment>& attachments) {
  check_material(material);
  check_mesh(mesh);
  const auto size = static_cast<Eigen::Index>(3 * mesh.nodes.size());
  if (mesh.parts.size() != 1) throw std::invalid_argument("reduce: the mesh must be of one part");
  if (modes < 0 || modes + 6 + static_cast<int>(attachments.size()) > size)
    throw std::invalid_argument("modes = " + std::to_string(modes) + ", must be in [0, " +
                                std::to_string(size - 6) + "]");
  const CellBatches cells(mesh, {material}, false);
  Vector mass(size);
  for (Eigen::Index d = 0; d < size; ++d) mass[d] = cells.masses()[static_cast<std::size_t>(d / 3)];
  const Sparse k = stiffness(mesh, material);
  const Matrix rigid = rigid_modes(mesh, mass);

  // a shift well below the first elastic mode: of the order of a wave's passage through the body, over 50
  Vec3 lo = mesh.nodes[0], hi = lo;
  for (const Vec3& p : mesh.nodes)
    for (int i = 0; i < 3; ++i) {
      lo[i] = std::min(lo[i], p[i]);
      hi[i] = std::max(hi[i], p[i]);
    }
  const double passage = std::sqrt(material.young / material.density) / norm(hi - lo),
               shift = std::pow(passage / 50, 2);
  Sparse shifted = k;
  for (Eigen::Index d = 0; d < size; ++d) shifted.coeffRef(d, d) += shift * mass[d];
  const Eigen::SimplicialLDLT<Sparse> solver(shifted);
  if (solver.info() != Eigen::Success)
    throw std::invalid_argument("reduce: the mesh hangs together badly; K + s M is singular");

  const Eigen::Index block = std::min<Eigen::Index>(size - 6, 2 * modes + 8);
  Matrix basis(size, block);
  for (Eigen::Index c = 0; c < block; ++c)
    for (Eigen::Index d = 0; d < size; ++d)
      basis(d, c) = std::sin(1.0 + static_cast<double>(d + 1) * (0.7 + 0.31 * static_cast<double>(c)));
  Vector values = Vector::Zero(block), last;
  for (int sweep = 0; modes > 0 && sweep < 60; ++sweep) {  // subspace iteration
    Matrix next = solver.solve(mass.asDiagonal() * basis);
    remove(rigid, mass, next);
    basis = orthonormal(next, mass);
    last = values;
    values = ritz(k, basis);
    const Eigen::Index seen = std::min<Eigen::Index>(modes, values.size());
    if (last.size() == values.size() &&
        ((values - last).head(seen).array().abs() < 1e-9 * values.head(seen).array().abs()).all())
      break;
  }
  Matrix shapes(size, modes + static_cast<Eigen::Index>(attachments.size()));
  if (modes > 0) shapes.leftCols(modes) = basis.leftCols(modes);
  for (std::size_t a = 0; a < attachments.size(); ++a) {
    Vector force = Vector::Zero(size);
    const Attachment& at = attachments[a];
    for (std::size_t n = 0; n < at.at.nodes.size(); ++n)
      for (int i = 0; i < 3; ++i) force[3 * at.at.nodes[n] + i] += at.at.shares[n] * at.direction[i];
    shapes.col(modes + static_cast<Eigen::Index>(a)) = solver.solve(force);
  }
  remove(rigid, mass, shapes);
  Matrix elastic = orthonormal(shapes, mass);
  const Vector squares = ritz(k, elastic);
  ModalBody body;
  body.nodes = static_cast<int>(mesh.nodes.size());
  body.omega.assign(6, 0.0);
  for (Eigen::Index r = 0; r < squares.size(); ++r)
    body.omega.push_back(std::sqrt(std::max(0.0, squares[r])));
  body.lowest_elastic = squares.size() > 0 ? body.omega[6] : 0;
  body.shapes.assign(rigid.data(), rigid.data() + rigid.size());
  body.shapes.insert(body.shapes.end(), elastic.data(), elastic.data() + elastic.size());
  return body;
}

ModalMotion::ModalMotion(const ModalBody& body, const SolidMesh& mesh, const std::vector<SolidPlane>& planes,
                         double dt)
    : body_(&body),
      mesh_(&mesh),
      planes_(planes),
      q_(body.omega.size(), 0.0),
      v_(body.omega.size(), 0.0),
      dt_(dt) {
  if (dt_ > 0) return;
  double square = body.omega.empty() ? 0 : body.omega.back() * body.omega.back();
  double added = 0;  // trace of the planes' stiffness in modal coordinates bounds what they add
  for (const auto& p : planes_)
    for (std::size_t k = 0; k < p.nodes.size(); ++k)
      for (int r = 0; r < body.modes(); ++r) {
        const double s = dot(body.shape(r, p.nodes[k]), p.normal);
        added += p.stiffness[k] * s * s;
      }
  dt_ = 0.2 * 2 / std::sqrt(square + added);
}

void ModalMotion::set_velocity(const Vec3& v) {
  for (int r = 0; r < 6; ++r) {  // v = sum of v_r phi_r: only the translations have a mean
    double sum = 0;
    for (int n = 0; n < body_->nodes; ++n) sum += dot(body_->shape(r, n), v);
    double square = 0;
    for (int n = 0; n < body_->nodes; ++n) square += dot(body_->shape(r, n), body_->shape(r, n));
    v_[static_cast<std::size_t>(r)] = r < 3 ? sum / square : 0;
  }
}

Vec3 ModalMotion::displacement(int node) const {
  Vec3 u;
  for (int r = 0; r < body_->modes(); ++r) u += q_[static_cast<std::size_t>(r)] * body_->shape(r, node);
  return u;
}

void ModalMotion::step() {
  std::vector<double> pull(q_.size(), 0.0);
  force_ = 0;
  for (const auto& p : planes_)
    for (std::size_t k = 0; k < p.nodes.size(); ++k) {
      const int n = p.nodes[k];
      const double depth =
          dot(p.point - mesh_->nodes[static_cast<std::size_t>(n)] - displacement(n), p.normal);
      if (depth <= 0) continue;
      const double f = p.stiffness[k] * depth;
      force_ += f;
      for (int r = 0; r < body_->modes(); ++r)
        pull[static_cast<std::size_t>(r)] += f * dot(body_->shape(r, n), p.normal);
    }
  for (std::size_t r = 0; r < q_.size(); ++r) {
    v_[r] += dt_ * (pull[r] - body_->omega[r] * body_->omega[r] * q_[r]);
    q_[r] += dt_ * v_[r];
  }
  time_ += dt_;
}

}  // namespace powbench::sim
