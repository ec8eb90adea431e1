#include "tiles/testing/emulation.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace tiles {

RecordedCosts RecordedCosts::Read(const std::filesystem::path& file) {
  RecordedCosts costs;
  std::ifstream in(file);
  in >> costs.width >> costs.height;
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream numbers(line);
    std::vector<double> frame;
    for (double us = 0.0; numbers >> us;) frame.push_back(1e-6 * us);
    if (!frame.empty()) costs.frames.push_back(std::move(frame));
  }
  return costs;
}

double RecordedCosts::Of(std::size_t frame, const Tile& tile) const {
  const int columns = (width + kSquare - 1) / kSquare;
  const std::vector<double>& squares = frames[frame % frames.size()];
  double cost_s = 0.0;
  for (int y = tile.y; y < tile.y + tile.height; y += kStep) {
    for (int x = tile.x; x < tile.x + tile.width; x += kStep) {
      const int pixels = std::min(kStep, tile.x + tile.width - x) * std::min(kStep, tile.y + tile.height - y);
      cost_s += squares[static_cast<std::size_t>(y / kSquare * columns + x / kSquare)] * pixels / (kSquare * kSquare);
    }
  }
  return cost_s;
}

Emulation::Emulation(const RecordedCosts* costs, std::size_t num_workers, double message_s, double per_tile_s)
    : costs_(costs),
      message_s_(message_s),
      per_tile_s_(per_tile_s),
      schedule_(num_workers),
      workers_(num_workers),
      sent_(num_workers) {
  for (std::size_t i = 0; i < num_workers; ++i) schedule_.Join(i, 0.0);
}

// What the viewer does between two messages.
void Emulation::Pump() {
  schedule_.Update(now_s_);
  while (schedule_.TakeDone()) done_s_.push_back(now_s_);
  while (schedule_.WantsFrame()) schedule_.BeginFrame(++next_frame_, costs_->width, costs_->height, now_s_);
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    if (schedule_.jobs(i) == sent_[i]) continue;
    sent_[i] = schedule_.jobs(i);
    At(now_s_ + message_s_, [this, i, list = sent_[i]] {
      workers_[i].list = list;
      Begin(i);
    });
  }
}

void Emulation::Begin(std::size_t worker) {
  Worker& at = workers_[worker];
  if (!at.is_running || at.is_busy) return;
  const auto next =
      std::find_if(at.list.begin(), at.list.end(), [&](const Job& job) { return at.begun.count(job.id) == 0; });
  if (next == at.list.end()) return;
  at.begun.insert(next->id);
  at.is_busy = true;
  const double cost_s = at.times * (per_tile_s_ + costs_->Of(next->frame, next->tile));
  At(now_s_ + cost_s, [this, worker, job = *next] { End(worker, job); });
}

void Emulation::End(std::size_t worker, const Job& job) {
  Worker& at = workers_[worker];
  if (!at.is_running) {
    at.frozen = job;
    return;
  }
  at.is_busy = false;
  const double cost_s = per_tile_s_ + costs_->Of(job.frame, job.tile);
  At(now_s_ + message_s_, [this, worker, id = job.id, cost_s] {
    if (schedule_.Take(worker, id, cost_s, now_s_)) work_s_ += cost_s;
  });
  Begin(worker);
}

void Emulation::Step() {
  // The viewer looks at its seats at least every millisecond.
  if (events_.empty() || events_.top().time_s > now_s_ + 1e-3) {
    now_s_ += 1e-3;
  } else {
    const Event event = events_.top();
    events_.pop();
    now_s_ = std::max(now_s_, event.time_s);
    event.act();
  }
  Pump();
}

void Emulation::RunFrames(std::size_t frames) {
  for (const std::size_t end = done_s_.size() + frames; done_s_.size() < end;) Step();
}

void Emulation::RunUntil(double time_s) {
  while (now_s_ < time_s) Step();
}

void Emulation::Kill(std::size_t worker) {
  workers_[worker].is_running = false;
}
void Emulation::Stop(std::size_t worker) {
  Kill(worker);
}
void Emulation::Continue(std::size_t worker) {
  Worker& at = workers_[worker];
  at.is_running = true;
  if (const auto job = std::exchange(at.frozen, std::nullopt)) End(worker, *job);
  Begin(worker);
}
void Emulation::Slow(std::size_t worker, double times) {
  workers_[worker].times = times;
}
void Emulation::Join(std::size_t worker) {
  workers_[worker] = Worker{};
  sent_[worker].clear();
  schedule_.Join(worker, now_s_);
}

double Emulation::Rate(double begin_s, double end_s) const {
  const auto count =
      std::count_if(done_s_.begin(), done_s_.end(), [&](double time_s) { return time_s >= begin_s && time_s < end_s; });
  return static_cast<double>(count) / (end_s - begin_s);
}

}  // namespace tiles
