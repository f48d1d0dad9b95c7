"""Module of 3D Slicer: shows a cut that is rehearsed in kerf, and sends planes and points to it while they are edited, and the bone."""

import ctk
import numpy
import qt
import slicer
import vtk
from slicer.ScriptedLoadableModule import (ScriptedLoadableModule, ScriptedLoadableModuleLogic, ScriptedLoadableModuleTest,
                                           ScriptedLoadableModuleWidget)
from slicer.util import VTKObservationMixin

from KerfLinkLib import messages

PORT = 18944
TOOL, TOOL_SHAPE, BONE, VALUES = "kerf_tool", "kerf_tool_shape", "kerf_bone", "kerf_values"
SEND_EVERY_MS = 50  # at most; kerf takes the newest in each frame of its window


class KerfLink(ScriptedLoadableModule):
    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "kerf link"
        self.parent.categories = ["IGT"]
        self.parent.dependencies = ["OpenIGTLinkIF", "Markups"]
        self.parent.contributors = ["The authors of kerf"]
        self.parent.helpText = ("Start kerf with <code>kerf rehearse BONE --igtl</code>, then connect. The saw and the bone appear as they "
                                "are in kerf. Tick a plane, and it moves in kerf while you move it here. <i>Send the bone</i> puts a "
                                "segmentation in the place of kerf's bone.")
        self.parent.acknowledgementText = ""


class KerfLinkWidget(ScriptedLoadableModuleWidget, VTKObservationMixin):
    def __init__(self, parent=None):
        ScriptedLoadableModuleWidget.__init__(self, parent)
        VTKObservationMixin.__init__(self)
        self.logic = None

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        self.logic = KerfLinkLogic()
        self._addConnection()
        self._addPlan()
        self._addBone()
        self.layout.addStretch(1)
        self.timer = qt.QTimer()
        self.timer.setInterval(200)
        self.timer.connect("timeout()", self.refresh)
        for event in (slicer.mrmlScene.NodeAddedEvent, slicer.mrmlScene.NodeRemovedEvent):
            self.addObserver(slicer.mrmlScene, event, self.listMarkups)
        self.addObserver(slicer.mrmlScene, slicer.mrmlScene.StartCloseEvent, self.onSceneStartClose)
        self.listMarkups()
        self.refresh()

    def cleanup(self):
        self.timer.stop()
        self.removeObservers()
        self.logic.disconnectFromKerf()

    def enter(self):
        self.timer.start()

    def exit(self):
        self.timer.stop()  # what is ticked is still sent

    def _addSection(self, title):
        section = ctk.ctkCollapsibleButton()
        section.text = title
        self.layout.addWidget(section)
        return qt.QFormLayout(section)

    def _addConnection(self):
        form = self._addSection("Connection")
        self.hostEdit = qt.QLineEdit("localhost")
        self.portBox = qt.QSpinBox()
        self.portBox.setRange(1, 65535)
        self.portBox.value = PORT
        self.connectButton = qt.QPushButton("Connect")
        self.connectButton.connect("clicked()", self.onConnect)
        self.stateLabel = qt.QLabel()
        self.valuesLabel = qt.QLabel()
        form.addRow("Host:", self.hostEdit)
        form.addRow("Port:", self.portBox)
        form.addRow(self.connectButton)
        form.addRow("State:", self.stateLabel)
        form.addRow("Values:", self.valuesLabel)

    def _addPlan(self):
        form = self._addSection("Plan")
        self.markupsList = qt.QListWidget()
        self.markupsList.toolTip = "Tick the planes that kerf takes over while they are moved"
        self.markupsList.connect("itemChanged(QListWidgetItem*)", self.onTicked)
        self.nerveSelector = slicer.qMRMLNodeComboBox()
        self.nerveSelector.nodeTypes = ["vtkMRMLMarkupsCurveNode", "vtkMRMLMarkupsFiducialNode"]
        self.nerveSelector.noneEnabled = True
        self.nerveSelector.addEnabled = self.nerveSelector.removeEnabled = False
        self.nerveSelector.setMRMLScene(slicer.mrmlScene)
        self.nerveSelector.connect("currentNodeChanged(vtkMRMLNode*)", lambda node: self.logic.sendNerve(node))
        form.addRow("Planes:", self.markupsList)
        form.addRow("Nerve:", self.nerveSelector)

    def _addBone(self):
        form = self._addSection("Bone")
        self.boneSelector = slicer.qMRMLNodeComboBox()
        self.boneSelector.nodeTypes = ["vtkMRMLSegmentationNode", "vtkMRMLLabelMapVolumeNode"]
        self.boneSelector.noneEnabled = True
        self.boneSelector.addEnabled = self.boneSelector.removeEnabled = False
        self.boneSelector.setMRMLScene(slicer.mrmlScene)
        self.boneSelector.toolTip = "Of a segmentation, the visible segments together are the bone"
        self.boneButton = qt.QPushButton("Send the bone")
        self.boneButton.toolTip = "kerf takes it in place of its own bone, and asks first if that has been cut"
        self.boneButton.connect("clicked()", lambda: self.logic.sendBone(self.boneSelector.currentNode()))
        form.addRow("Segmentation:", self.boneSelector)
        form.addRow(self.boneButton)

    def onConnect(self):
        if self.logic.connector is None:
            self.logic.connectToKerf(self.hostEdit.text, self.portBox.value)
        else:
            self.logic.disconnectFromKerf()
        self.refresh()

    def onSceneStartClose(self, caller=None, event=None):
        self.logic.disconnectFromKerf()

    def listMarkups(self, caller=None, event=None):
        self.markupsList.blockSignals(True)
        self.markupsList.clear()
        for node in slicer.util.getNodesByClass("vtkMRMLMarkupsPlaneNode"):
            item = qt.QListWidgetItem(node.GetName())
            item.setData(qt.Qt.UserRole, node.GetID())
            item.setFlags(item.flags() | qt.Qt.ItemIsUserCheckable)
            item.setCheckState(qt.Qt.Checked if self.logic.isSent(node) else qt.Qt.Unchecked)
            self.markupsList.addItem(item)
        self.markupsList.blockSignals(False)

    def onTicked(self, item):
        node = slicer.mrmlScene.GetNodeByID(item.data(qt.Qt.UserRole))
        if node is None:
            return
        if item.checkState() == qt.Qt.Checked:
            self.logic.sendPlane(node)
        else:
            self.logic.stopSending(node)

    def refresh(self):
        self.connectButton.text = "Connect" if self.logic.connector is None else "Disconnect"
        self.boneButton.enabled = self.logic.connector is not None and self.boneSelector.currentNode() is not None
        self.stateLabel.text = self.logic.state()
        self.valuesLabel.text = self.logic.values()
        self.logic.showTool()


class KerfLinkLogic(ScriptedLoadableModuleLogic, VTKObservationMixin):
    """Everything that needs no widget."""

    def __init__(self):
        ScriptedLoadableModuleLogic.__init__(self)
        VTKObservationMixin.__init__(self)
        self.connector = None
        self._sent = {}  # ID of a markups node -> the node that is sent for it
        self._due = set()  # IDs of changed markups nodes
        self._bone = None  # label map that was sent last
        self._timer = qt.QTimer()
        self._timer.setSingleShot(True)
        self._timer.setInterval(SEND_EVERY_MS)
        self._timer.connect("timeout()", self._sendDue)

    # ---- connection
    def connectToKerf(self, host="localhost", port=PORT):
        self.connector = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLIGTLConnectorNode", "kerf")
        self.connector.SetTypeClient(host, port)
        self.connector.Start()
        for markups in list(self._sent):
            self._due.add(markups)
        self._timer.start()

    def disconnectFromKerf(self):
        if self.connector is None:
            return
        self.connector.Stop()
        slicer.mrmlScene.RemoveNode(self.connector)
        self.connector = None

    def state(self):
        if self.connector is None:
            return "not connected"
        if self.connector.GetState() != slicer.vtkMRMLIGTLConnectorNode.StateConnected:
            return "waiting for kerf (kerf rehearse BONE --igtl)"
        status = slicer.mrmlScene.GetFirstNode("kerf", "vtkMRMLIGTLStatusNode")
        return status.GetStatusString() if status is not None else "connected"

    def values(self):
        node = slicer.mrmlScene.GetFirstNode(VALUES, "vtkMRMLTextNode")
        return messages.show_values(node.GetText()) if node is not None and node.GetText() else ""

    def showTool(self):
        """Puts the shape of the tool under its transform, once both have arrived."""
        shape = slicer.mrmlScene.GetFirstNode(TOOL_SHAPE, "vtkMRMLModelNode")
        pose = slicer.mrmlScene.GetFirstNode(TOOL, "vtkMRMLLinearTransformNode")
        if shape is not None and pose is not None and shape.GetTransformNodeID() != pose.GetID():
            shape.SetAndObserveTransformNodeID(pose.GetID())

    # ---- plan
    def isSent(self, markups):
        return markups.GetID() in self._sent

    def sendPlane(self, plane):
        self._send(plane, "vtkMRMLLinearTransformNode", messages.plane_message_name(plane.GetName()))

    def sendNerve(self, markups):
        """Sends the points of a curve or of a list of points as the nerve; None: none any more."""
        for markupsId in list(self._sent):
            node = slicer.mrmlScene.GetNodeByID(markupsId)
            if node is not None and not node.IsA("vtkMRMLMarkupsPlaneNode"):
                self.stopSending(node)
        if markups is not None:
            self._send(markups, "vtkMRMLMarkupsFiducialNode", messages.NERVE_NAME)

    def stopSending(self, markups):
        sent = self._sent.pop(markups.GetID(), None)
        self._due.discard(markups.GetID())
        self.removeObserver(markups, vtk.vtkCommand.ModifiedEvent, self._onModified)
        self.removeObserver(markups, slicer.vtkMRMLMarkupsNode.PointModifiedEvent, self._onModified)
        if sent is not None:
            slicer.mrmlScene.RemoveNode(sent)

    def _send(self, markups, className, name):
        if self.isSent(markups):
            return
        sent = slicer.mrmlScene.CreateNodeByClass(className)
        sent.UnRegister(None)
        sent.SetName(name)
        sent.SetHideFromEditors(True)
        sent.SetSaveWithScene(False)
        self._sent[markups.GetID()] = slicer.mrmlScene.AddNode(sent)
        self.addObserver(markups, vtk.vtkCommand.ModifiedEvent, self._onModified)
        self.addObserver(markups, slicer.vtkMRMLMarkupsNode.PointModifiedEvent, self._onModified)
        self._onModified(markups)

    # ---- bone
    def sendBone(self, source):
        """Sends a label map, or the visible segments of a segmentation, as the bone."""
        if source is None or self.connector is None:
            return
        if self._bone is not None:
            slicer.mrmlScene.RemoveNode(self._bone)
        self._bone = self._makeBone(source)
        self._bone.SetHideFromEditors(True)
        self._bone.SetSaveWithScene(False)
        self.connector.RegisterOutgoingMRMLNode(self._bone)
        self.connector.PushNode(self._bone)

    @staticmethod
    def _makeBone(source):
        if source.IsA("vtkMRMLSegmentationNode"):
            labels = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLLabelMapVolumeNode", BONE)
            slicer.modules.segmentations.logic().ExportVisibleSegmentsToLabelmapNode(source, labels)
        else:
            labels = slicer.modules.volumes.logic().CloneVolume(source, BONE)
        voxels = slicer.util.arrayFromVolume(labels)
        voxels[voxels != 0] = 1  # kerf takes one label
        slicer.util.arrayFromVolumeModified(labels)
        return labels

    def _onModified(self, caller, event=None):
        self._due.add(caller.GetID())
        if not self._timer.isActive():
            self._timer.start()

    def _sendDue(self):
        if self.connector is None:
            return
        for markupsId in list(self._due):
            markups = slicer.mrmlScene.GetNodeByID(markupsId)
            sent = self._sent.get(markupsId)
            if markups is None or sent is None or markups.GetNumberOfControlPoints() == 0:
                continue
            if markups.IsA("vtkMRMLMarkupsPlaneNode"):
                self._copyPlane(markups, sent)
            else:
                slicer.util.updateMarkupsControlPointsFromArray(sent, slicer.util.arrayFromMarkupsControlPoints(markups, world=True))
            self.connector.RegisterOutgoingMRMLNode(sent)
            self.connector.PushNode(sent)
        self._due.clear()

    @staticmethod
    def _copyPlane(plane, transform):
        centre, normal, x, y, z = ([0.0, 0.0, 0.0] for _ in range(5))
        plane.GetCenterWorld(centre)
        plane.GetNormalWorld(normal)
        plane.GetAxesWorld(x, y, z)
        matrix = vtk.vtkMatrix4x4()
        for i, row in enumerate(messages.plane_matrix(centre, normal, x)):
            for j, value in enumerate(row):
                matrix.SetElement(i, j, value)
        transform.SetMatrixTransformToParent(matrix)


class KerfLinkTest(ScriptedLoadableModuleTest):
    """Tests with Slicer, without kerf."""

    def setUp(self):
        slicer.mrmlScene.Clear()

    def runTest(self):
        self.setUp()
        self.test_planeIsCopied()
        self.setUp()
        self.test_nerveIsCopied()
        self.setUp()
        self.test_boneHasOneLabel()

    def test_planeIsCopied(self):
        plane = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsPlaneNode", "left")
        plane.SetCenter([1, 2, 3])
        plane.SetNormal([0, 1, 0])
        logic = KerfLinkLogic()
        logic.connectToKerf()
        logic.sendPlane(plane)
        logic._sendDue()
        sent = slicer.mrmlScene.GetFirstNode("kerf_plan/left", "vtkMRMLLinearTransformNode")
        matrix = vtk.vtkMatrix4x4()
        sent.GetMatrixTransformToParent(matrix)
        self.assertEqual([round(matrix.GetElement(i, 3), 6) for i in range(3)], [1, 2, 3])
        self.assertEqual([round(matrix.GetElement(i, 2), 6) for i in range(3)], [0, 1, 0])
        logic.stopSending(plane)
        logic.disconnectFromKerf()
        self.delayDisplay("A plane is copied")

    def test_nerveIsCopied(self):
        curve = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "canal")
        for point in ([0, 0, 0], [10, 0, 0]):
            curve.AddControlPoint(point)
        logic = KerfLinkLogic()
        logic.connectToKerf()
        logic.sendNerve(curve)
        logic._sendDue()
        sent = slicer.mrmlScene.GetFirstNode("nerve", "vtkMRMLMarkupsFiducialNode")
        self.assertEqual(sent.GetNumberOfControlPoints(), 2)
        logic.sendNerve(None)
        logic.disconnectFromKerf()
        self.delayDisplay("The nerve is copied")

    def test_boneHasOneLabel(self):
        labels = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLLabelMapVolumeNode", "teeth and bone")
        slicer.util.updateVolumeFromArray(labels, numpy.array([[[0, 1, 2], [0, 0, 5]]], dtype=numpy.uint8))
        bone = KerfLinkLogic._makeBone(labels)
        self.assertEqual(slicer.util.arrayFromVolume(bone).tolist(), [[[0, 1, 1], [0, 0, 1]]])
        self.assertEqual(slicer.util.arrayFromVolume(labels).max(), 5)
        self.assertEqual(bone.GetName(), "kerf_bone")
        self.delayDisplay("The bone has one label")
