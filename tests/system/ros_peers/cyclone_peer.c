/* cyclone_peer DOMAIN PREFIX VERB...: a ROS 2 node's side on Cyclone DDS, by its C API and types that idlc makes of
 * rosidl.idl. Hears joint states, trajectory and diagnostics, then calls the services VERB one after the other, and prints a
 * line for each. CYCLONEDDS_URI is heeded, as in a ROS process. Ends with 0 once all of it has come, with 1 after a minute. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>

#include "rosidl.h"

static char name[512];

static const char* topicName(const char* kind, const char* prefix, const char* end) {
  snprintf(name, sizeof name, "%s/%s%s", kind, prefix, end);
  return name;
}

static dds_entity_t topicOf(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* topic) {
  return dds_create_topic(participant, type, topic, NULL, NULL);
}

/* What USER_DATA a matched writer of `topic` announces. */
static int announcesHash(dds_entity_t reader, const char* hash) {
  dds_instance_handle_t writers[4];
  const dds_return_t count = dds_get_matched_publications(reader, writers, 4);
  int found = 0;
  for (dds_return_t i = 0; i < count && i < 4; ++i) {
    dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writers[i]);
    void* data = NULL;
    size_t size = 0;
    if (endpoint == NULL) continue;
    if (dds_qget_userdata(endpoint->qos, &data, &size) && data != NULL && strstr((char*)data, hash) != NULL) found = 1;
    dds_free(data);
    dds_builtintopic_free_endpoint(endpoint);
  }
  return found;
}

enum { kMostVerbs = 8 };

struct Service {
  const char* verb;
  dds_entity_t request, reply;
};

static struct Service serviceOf(dds_entity_t participant, const dds_qos_t* qos, const char* prefix, const char* verb) {
  struct Service service = {verb, 0, 0};
  char end[256];
  snprintf(end, sizeof end, "handgraft_bridge/%sRequest", verb);
  service.request = dds_create_writer(
      participant, topicOf(participant, &std_srvs_srv_dds__Trigger_Request__desc, topicName("rq", prefix, end)), qos, NULL);
  snprintf(end, sizeof end, "handgraft_bridge/%sReply", verb);
  service.reply = dds_create_reader(
      participant, topicOf(participant, &std_srvs_srv_dds__Trigger_Response__desc, topicName("rr", prefix, end)), qos, NULL);
  return service;
}

static int isMatched(const struct Service* service) {
  dds_publication_matched_status_t asked = {0};
  dds_subscription_matched_status_t answered = {0};
  dds_get_publication_matched_status(service->request, &asked);
  dds_get_subscription_matched_status(service->reply, &answered);
  return asked.current_count > 0 && answered.current_count > 0;
}

int main(int argc, char** argv) {
  if (argc < 4 || argc - 3 > kMostVerbs) return 2;
  const char* prefix = argv[2];
  const int verbs = argc - 3;
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  if (participant < 0) return 1;
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  struct Service services[kMostVerbs];
  for (int k = 0; k < verbs; ++k) {
    services[k] = serviceOf(participant, qos, prefix, argv[3 + k]);
    if (services[k].request < 0 || services[k].reply < 0) return 1;
  }
  const dds_entity_t joints = dds_create_reader(
      participant, topicOf(participant, &sensor_msgs_msg_dds__JointState__desc, topicName("rt", prefix, "joint_states")), qos, NULL);
  const dds_entity_t trajectory = dds_create_reader(
      participant, topicOf(participant, &trajectory_msgs_msg_dds__JointTrajectory__desc, topicName("rt", prefix, "joint_trajectory")),
      qos, NULL);
  const dds_entity_t diagnostics = dds_create_reader(
      participant, topicOf(participant, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics"), qos, NULL);
  if (joints < 0 || trajectory < 0 || diagnostics < 0) return 1;

  int has_joints = 0, has_trajectory = 0, has_diagnostics = 0, has_hash = 0;
  int answered = 0;       /* services so far */
  int asked_at = -100000; /* turn in which the next one was asked */
  for (int i = 0; i < 1200 && answered < verbs; ++i) {
    void* sample = NULL;
    dds_sample_info_t info;
    while (dds_take(joints, &sample, &info, 1, 1) > 0) {
      const sensor_msgs_msg_dds__JointState_* told = sample;
      if (info.valid_data && !has_joints && told->name_._length > 0) {
        has_joints = 1;
        printf("joint_states %u names, first %s, %u positions, %u efforts, frame %s\n", told->name_._length,
               told->name_._buffer[0], told->position_._length, told->effort_._length, told->header_.frame_id_);
      }
      dds_return_loan(joints, &sample, 1);
      sample = NULL;
    }
    while (dds_take(trajectory, &sample, &info, 1, 1) > 0) {
      const trajectory_msgs_msg_dds__JointTrajectory_* told = sample;
      if (info.valid_data && !has_trajectory) {
        has_trajectory = 1;
        printf("joint_trajectory %u names, %u points, %u positions, in %u ns\n", told->joint_names_._length,
               told->points_._length, told->points_._buffer[0].positions_._length,
               told->points_._buffer[0].time_from_start_.nanosec_);
      }
      dds_return_loan(trajectory, &sample, 1);
      sample = NULL;
    }
    while (dds_take(diagnostics, &sample, &info, 1, 1) > 0) {
      const diagnostic_msgs_msg_dds__DiagnosticArray_* told = sample;
      if (info.valid_data && !has_diagnostics) {
        has_diagnostics = 1;
        printf("diagnostics level %u of %s: %s\n", told->status_._buffer[0].level_, told->status_._buffer[0].name_,
               told->status_._buffer[0].hardware_id_);
      }
      dds_return_loan(diagnostics, &sample, 1);
      sample = NULL;
    }
    if (!has_hash && announcesHash(joints, "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;")) {
      has_hash = 1;
      printf("joint_states announces its type hash\n");
    }
    const struct Service* next = &services[answered];
    while (dds_take(next->reply, &sample, &info, 1, 1) > 0) {
      const std_srvs_srv_dds__Trigger_Response_* told = sample;
      if (info.valid_data && told->client_guid_ == 4711 && told->sequence_number_ == 42 + answered && asked_at >= 0) {
        printf("%s success %d: %s\n", next->verb, told->success_, told->message_);
        asked_at = -100000;
        ++answered;
      }
      dds_return_loan(next->reply, &sample, 1);
      sample = NULL;
      if (asked_at < 0) break;
    }
    /* A match is not readiness: a request may be lost, and is repeated after 3 s. */
    const int is_due = asked_at < 0 || i - asked_at > 60;
    if (answered < verbs && has_joints && has_trajectory && has_diagnostics && has_hash && is_due && isMatched(&services[answered])) {
      std_srvs_srv_dds__Trigger_Request_ question = {.client_guid_ = 4711, .sequence_number_ = 42 + answered};
      if (dds_write(services[answered].request, &question) == 0) asked_at = i;
    }
    fflush(stdout);
    dds_sleepfor(DDS_MSECS(50));
  }
  dds_delete_qos(qos);
  dds_delete(participant);
  return answered == verbs ? 0 : 1;
}
