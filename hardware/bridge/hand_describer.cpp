#include "hardware/bridge/hand_describer.h"

#include <chrono>
#include <exception>
#include <utility>

namespace handgraft::bridge {

namespace {

constexpr std::chrono::milliseconds kPause(200);  // before a silent server is asked again

}  // namespace

HandDescriber::HandDescriber(const idl::cyclone::Participant& participant)
    : requester_(participant), worker_([this] {
        work();
      }) {}

HandDescriber::~HandDescriber() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  requester_.cancel();
  worker_.join();
}

void HandDescriber::want(const std::optional<HandQuestion>& question) {
  {
    const std::lock_guard lock(mutex_);
    if (wanted_ == question) return;
    wanted_ = question;
    is_new_ = question.has_value();
    answer_.reset();
  }
  changed_.notify_all();
}

std::optional<HandDescriber::Answer> HandDescriber::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(answer_, std::nullopt);
}

void HandDescriber::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] {
      return stopping_ || is_new_;
    });
    if (stopping_) return;
    const HandQuestion question = *wanted_;
    lock.unlock();
    std::optional<Answer> answer;
    try {
      answer = ask(question);
    } catch (const TransportError&) {
      // No server, or not any more: asked again while the question stands.
    } catch (const std::exception& error) {
      answer = Answer{question, std::nullopt, error.what()};
    }
    lock.lock();
    if (wanted_ != question) continue;
    if (answer) {
      answer_ = std::move(answer);
      is_new_ = false;
    } else {
      changed_.wait_for(lock, kPause, [&] {
        return stopping_ || wanted_ != question;
      });
    }
  }
}

HandDescriber::Answer HandDescriber::ask(const HandQuestion& question) {
  v1::DescribeModelRequest request;
  v1::ModelKey key;
  key.kind(v1::MODEL_HAND);
  key.name(question.hand);
  request.model(key);
  request.with_meshes(false);
  v1::RequestBody body;
  body.describe_model(request);
  body._d(v1::OP_DESCRIBE_MODEL);
  v1::ReplyBody reply = requester_.ask(body);
  if (reply._d() != v1::OP_DESCRIBE_MODEL || reply.model()._d() != v1::MODEL_HAND) {
    return {question, std::nullopt, "the server's answer does not describe a hand"};
  }
  return {question, std::move(reply.model().hand()), {}};
}

}  // namespace handgraft::bridge
